// Bodies as arrays, as a program of another author or Python hands them over: depth pictures, CT
// volumes, meshes, spheres, columns.
#include <cloudcontact/objects/digital_object.h>
#include <cloudcontact/voxels/ct_volume.h>
#include <cloudcontact/voxels/digitize.h>

#include "fuzz/fuzz_input.h"
#include "fuzz/fuzz_target.h"

namespace cloudcontact::fuzz {

namespace {

constexpr std::size_t kMostOfAnArray = std::size_t{1} << 24;

void depthPicture(Draw& draw) {
  DepthImage image;
  image.width = draw.upTo(12), image.height = draw.upTo(12);
  const double far = draw.length();
  const int count = image.width * image.height - draw.upTo(20) / 20;
  for (int k = 0; k < count; ++k)
    image.points.emplace_back(0.01 * (k % 12), 0.01 * (k / 12), far + draw.length());
  image.viewpoint = draw.vector();
  DepthCloudSettings settings;
  settings.voxelSize = 0.005 * draw.upTo(3);
  settings.thickness = draw.length();
  settings.backing = draw.upTo(1) ? Backing::Rays : Backing::Shell;
  settings.image.jump = draw.length();
  settings.image.smoothing = draw.upTo(5) - 1;
  settings.image.threads = 1;
  mayRefuse("", [&] { mended(image, settings.image); });
  mayRefuse("", [&] { toMesh(image, settings.image); });
  mayRefuse("", [&] {
    if (boundsOf(image).sizes().maxCoeff() + std::abs(settings.thickness) < 0.1)
      toCloud(image, settings);
  });
}

void volume(Draw& draw) {
  CtVolume ct;
  ct.size = {draw.upTo(9), draw.upTo(9), draw.upTo(9)};
  ct.spacing = draw.vector();
  ct.origin = draw.vector();
  for (int k = ct.size.prod() - draw.upTo(20) / 20; k > 0; --k)
    ct.values.push_back(draw.upTo(9) == 9 ? draw.take<float>() : float(draw.take<std::int8_t>()));
  std::vector<CtRange> ranges;
  for (int k = draw.upTo(3); k > 0; --k)
    ranges.push_back({draw.upTo(5) == 5 ? draw.take<double>() : 10 * draw.upTo(9), "part"});
  CtSettings settings;
  settings.maxBytes = kMostOfAnArray;
  settings.voxelSize = draw.upTo(3) ? 0 : draw.length();
  mayRefuse("cloudFromCt", [&] { cloudFromCt(ct, ranges, settings); });
}

void mesh(Draw& draw) {
  Mesh body = draw.upTo(1) ? cube(0.01 * draw.upTo(5)) : Mesh{};
  for (int k = draw.upTo(20); k > 0; --k) body.vertices.push_back(draw.vector());
  const int most = static_cast<int>(body.vertices.size()) + draw.upTo(30) / 30;
  for (int k = draw.upTo(30); k > 0; --k)
    body.triangles.push_back({draw.upTo(most), draw.upTo(most), draw.upTo(most)});
  mayRefuse("", [&] {
    const double voxel = draw.upTo(9) ? 3 * suggestedVoxel(body) : draw.length();
    digitizeSmall(body, voxel);
  });
}

// Only tame bodies become voxels: the memory of these is checked against the machine's.
void spheres(Draw& draw) {
  SphereCloud body;
  for (int k = draw.upTo(9); k > 0; --k)
    body.centers.push_back(draw.vector()), body.radii.push_back(draw.length());
  if (draw.upTo(1))
    body.materials = {"a"}, body.material.assign(body.radii.size(), std::uint8_t(draw.upTo(1)));
  mayRefuse("", [&] {
    const SphereTree tree(body);
    const Eigen::AlignedBox3d box = boundsOf(body);
    if (box.isEmpty() || box.sizes().maxCoeff() > 10) return;
    toCloud(tree, box.sizes().maxCoeff() / 20);
    toCloud(body, box.sizes().maxCoeff() / 20, 1);
  });
}

void columns(Draw& draw) {
  ColumnCloud body;
  body.axis = draw.upTo(3), body.width = draw.length();
  body.origin = draw.vector();
  body.columns = {draw.upTo(5), draw.upTo(5)};
  body.first = {0};
  for (int c = body.columns.prod(); c > 0; --c) {
    double low = 0;
    for (int k = draw.upTo(2); k > 0; --k) {
      low += draw.length();
      body.intervals.push_back({low, low + draw.length(), 1.0f, 0});
    }
    body.first.push_back(body.intervals.size() + (draw.upTo(100) == 100));
  }
  mayRefuse("", [&] {
    const Eigen::AlignedBox3d box = boundsOf(body);
    if (box.isEmpty() || box.sizes().maxCoeff() > 10) return;
    toCloud(body, box.sizes().maxCoeff() / 20);
  });
}

void read(std::string_view input) {
  Draw draw(input);
  constexpr void (*kKinds[])(Draw&) = {depthPicture, volume, mesh, spheres, columns};
  kKinds[draw.upTo(4)](draw);
}

std::vector<std::string> seeds() {
  std::vector<std::string> all;
  unsigned state = 7;
  for (int kind = 0; kind < 5; ++kind)
    for (int n = 0; n < 6; ++n) {
      std::string seed(1, static_cast<char>(kind));
      for (int k = 0; k < 600; ++k)
        seed += static_cast<char>((state = state * 1664525 + 1013904223) >> 24);
      all.push_back(seed);
    }
  return all;
}

}  // namespace

Target arraysTarget() {
  return {"arrays", read, seeds, 2048};
}

}  // namespace cloudcontact::fuzz
