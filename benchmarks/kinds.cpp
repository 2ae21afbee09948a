// Which digital kind answers fastest what a contact asks, at equal outcome: is there material at a
// point, how deep is it, and which voxels of a workpiece lie in a tool. All times of a row come
// from one run on one thread, as ratios to that of the voxels.
//
// kinds [FOLDER with spot.obj, tooth.obj and nut_m16_loose.obj]
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/mesh/mesh_file.h>
#include <cloudcontact/mesh/mesh_repair.h>
#include <cloudcontact/objects/digital_object.h>
#include <cloudcontact/voxels/digitize.h>
#include <cloudcontact/workpiece/interference.h>

#include <array>
#include <cstdio>
#include <random>
#include <set>
#include <string>

#include "kind_pairs.h"
#include "timing.h"

namespace {

using namespace cloudcontact;
using Eigen::Vector3i;
using Voxels = FoundVoxels;

constexpr double kLongest = 64;  // of a mesh [voxels]
constexpr int kTimes = 15, kPoints = 20000;

volatile double sink = 0;

// The median of several times [s].
template <typename Work>
double timeOf(Work&& work) {
  std::vector<double> times;
  for (int k = 0; k < kTimes; ++k) times.push_back(seconds(work));
  return median(times);
}

Cloud meshCloud(const std::string& file) {
  const Mesh mesh = mended(loadMesh(file));
  Eigen::AlignedBox3d box;
  for (const Vec3& v : mesh.vertices) box.extend(v);
  DigitizeSettings settings;
  settings.voxelSize = box.sizes().maxCoeff() / kLongest;
  return digitize(mesh, settings);
}

// A ball, and a needle across the grid, of spheres; voxels of 1 mm.
Cloud ball(double radius) {
  return toCloud(SphereCloud{{Vec3::Zero()}, {1e-3 * radius}, {}, {}}, 1e-3);
}
Cloud needle() {
  SphereCloud spheres;
  for (int k = 0; k <= 80; ++k) {
    spheres.centers.push_back(1e-3 * 0.5 * k * Vec3(1, 0.8, 0.6).normalized());
    spheres.radii.push_back(1.5e-3);
  }
  return toCloud(spheres, 1e-3);
}

Cloud withVoxel(const Cloud& cloud, double voxel) {
  return Cloud(voxel, cloud.origin() * (voxel / cloud.voxelSize()),
               std::make_shared<Cloud::Voxels>(cloud.voxels()));
}

Eigen::AlignedBox3d boxOf(const Cloud& cloud) {
  return boundsOf(DigitalObject(cloud));
}

std::size_t apart(const Voxels& a, const Voxels& b) {
  const auto key = [](const VoxelIndex& v) { return std::array{v.x(), v.y(), v.z()}; };
  std::set<std::array<int, 3>> x, y;
  for (const VoxelIndex& v : a) x.insert(key(v));
  for (const VoxelIndex& v : b) y.insert(key(v));
  std::size_t both = 0;
  for (const auto& v : x) both += y.count(v);
  return x.size() + y.size() - 2 * both;
}

// --- One point.

void pointRow(const char* name, const Cloud& cloud) {
  const Octree octree(cloud);
  const SphereTree cubes(cloud), spheres(inscribedSpheres(cloud));
  const auto field = SurfaceField::build(cloud);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  const Eigen::AlignedBox3d box = boxOf(cloud);
  std::vector<Vec3> anywhere, near;
  while (anywhere.size() < kPoints)
    anywhere.push_back(box.min() +
                       Vec3(unit(random), unit(random), unit(random)).cwiseProduct(box.sizes()));
  const double h = cloud.voxelSize();
  for (std::size_t k = 0; near.size() < kPoints; k = (k + 7) % field->sampleCount()) {
    const SurfaceSample s = field->sample(k);
    const Vec3 at(s.position[0], s.position[1], s.position[2]);
    near.push_back(cloud.origin() +
                   h * (at + Vec3(unit(random), unit(random), unit(random)) - Vec3::Constant(0.5)));
  }
  const auto each = [&](const std::vector<Vec3>& points, auto&& ask) {
    return timeOf([&] {
             double sum = 0;
             for (const Vec3& p : points) sum += ask(p);
             sink = sum;
           }) /
           double(points.size());
  };
  const auto voxelAt = [&](const Vec3& p) {
    return Vector3i(((p - cloud.origin()) / h).array().floor().cast<int>());
  };
  const double byVoxels = each(anywhere, [&](const Vec3& p) {
    const Vector3i v = voxelAt(p);
    return cloud.coverage(v.x(), v.y(), v.z());
  });
  const double byOctree =
      each(anywhere, [&](const Vec3& p) { return octree.at(voxelAt(p)).coverage; });
  const double byTree = each(anywhere, [&](const Vec3& p) {
    double most = 0;
    forEachNear(cubes, p, 0, [&](const SphereTree::Leaf& l) {
      if ((p - l.center).cwiseAbs().maxCoeff() <= halfEdge(l)) most = l.share;
    });
    return most;
  });
  const double byField = each(near, [&](const Vec3& p) {
    const auto found = field->at(p);
    return found ? found->depth : 0;
  });
  double error = 0;
  const auto depthInSpheres = [&](const Vec3& p) {
    double depth = -1;
    forEachNear(spheres, p, h, [&](const SphereTree::Leaf& l) {
      depth = std::max(depth, l.radius - (p - l.center).norm());
    });
    return depth;
  };
  const double bySpheres = each(near, depthInSpheres);
  int inside = 0;
  for (const Vec3& p : near)
    if (const auto found = field->at(p); found && found->depth > 0)
      error += std::abs(depthInSpheres(p) - found->depth) / h, ++inside;
  std::printf(
      "%-14s material: voxels %5.1f ns, octree %5.2f, sphere tree %6.1f | depth: field "
      "%5.1f ns, %zu inscribed spheres %6.1f (%.2f voxel off)\n",
      name, 1e9 * byVoxels, byOctree / byVoxels, byTree / byVoxels, 1e9 * byField,
      spheres.leaves().size(), bySpheres / byField, error / std::max(inside, 1));
}

// --- A pair.

struct Case {
  std::string name;
  Cloud tool, work;
  Pose place;  // of the tool in the workpiece
};

void pairRow(const Case& c) {
  const Octree octree(c.work);
  const PointCloud many = centerPoints(c.tool, 3), points = centerPoints(c.tool);
  const ColumnCloud toolColumns = toColumns(c.tool, 2, 1), columns = toColumns(c.work, 2, 1);
  const SphereTree toolTree(c.tool), workTree(c.work);
  Voxels voxels, other;
  const double byVoxels = timeOf([&] { voxels = interference(c.tool, c.place, c.work); });
  std::printf("%-30s %6zu voxels: voxels %8.1f us", c.name.c_str(), voxels.size(), 1e6 * byVoxels);
  const auto row = [&](const char* name, auto&& ask) {
    const double time = timeOf([&] { other = ask(); });
    std::printf(", %s %.2f (%zu)", name, time / byVoxels, apart(voxels, other));
  };
  row("columns", [&] { return columnsInColumns(toolColumns, c.place, columns); });
  row("points/octree", [&] { return pointsInOctree(points, c.place, octree); });
  row("points/voxels", [&] { return pointsInVoxels(points, c.place, c.work); });
  row("27 points/octree", [&] { return pointsInOctree(many, c.place, octree); });
  row("tree/tree", [&] { return treeInTree(toolTree, c.place, workTree, c.work); });
  row("tree/columns", [&] { return treeInColumns(toolTree, c.place, columns, c.work); });
  // What collides in a world: samples of both surfaces, each looked up in the other's field.
  const auto a = SurfaceField::build(c.work), b = SurfaceField::build(c.tool);
  ContactFinder finder;
  ContactSettings settings;
  const double contact = timeOf([&] {
    ContactBody work, tool;
    work.field = a.get(), tool.field = b.get(), tool.pose = c.place;
    finder.find(work, tool, settings);
  });
  std::printf(", contact %.2f\n", contact / byVoxels);
}

Pose pushed(const Cloud& tool, const Cloud& work, double depth, const Eigen::Quaterniond& turn) {
  // Above the work's middle, its lowest point `depth` voxels below the work's highest.
  Eigen::AlignedBox3d turned;
  for (const Vec3& p : centerPoints(tool).positions) turned.extend(Vec3(turn * p));
  const Eigen::AlignedBox3d box = boxOf(work);
  Vec3 at = box.center() - turned.center();
  at.z() = box.max().z() - turned.min().z() - depth * work.voxelSize();
  return {turn, at};
}

}  // namespace

int main(int count, char** arguments) {
  const std::string folder = count > 1 ? arguments[1] : "../shared/data";
  const Cloud sphere = ball(24), spot = withVoxel(meshCloud(folder + "/spot.obj"), 1e-3),
              tooth = withVoxel(meshCloud(folder + "/tooth.obj"), 1e-3),
              nut = withVoxel(meshCloud(folder + "/nut_m16_loose.obj"), 1e-3);
  pointRow("ball", sphere), pointRow("spot", spot), pointRow("tooth", tooth), pointRow("nut", nut);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
  const struct {
    const char* name;
    const Cloud& cloud;
  } bodies[] = {{"ball", sphere}, {"spot", spot}, {"tooth", tooth}, {"nut", nut}};
  const Cloud bur = ball(4), thin = needle();
  for (const auto& body : bodies)
    for (const double depth : {-4.0, 1.0, 12.0}) {
      char label[64];
      std::snprintf(label, sizeof label, " on %s, %g deep", body.name, depth);
      pairRow({"itself" + std::string(label), body.cloud, body.cloud,
               pushed(body.cloud, body.cloud, depth, turn)});
      pairRow({"bur" + std::string(label), bur, body.cloud, pushed(bur, body.cloud, depth, turn)});
      pairRow(
          {"needle" + std::string(label), thin, body.cloud, pushed(thin, body.cloud, depth, turn)});
    }
}
