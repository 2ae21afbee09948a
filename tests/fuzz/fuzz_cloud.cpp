// `.cloud` files of all kinds, and the cache's, which holds such files. A file as it is meets the
// checksum first; with a right checksum all that is behind it is reached.
#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/objects/object_file.h>
#include <cloudcontact/voxels/cloud_file.h>

#include "base/hash.h"
#include "fuzz/fuzz_input.h"
#include "fuzz/fuzz_target.h"
#include "scene/shape_cache.h"
#include "voxels/cloud_bytes.h"

namespace cloudcontact::fuzz {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kVersionAt = 8, kLengthAt = 16, kPayloadAt = 24;

// The input as a file whose lengths and checksum are right.
std::string sealed(std::string_view input) {
  std::string file(input);
  if (file.size() >= kPayloadAt && file[kVersionAt] == char(kAnyObject)) {
    const std::uint64_t length = file.size() - kPayloadAt;
    std::memcpy(file.data() + kLengthAt, &length, sizeof length);
  }
  Fnv1a hash;
  hash.add(file.data(), file.size());
  add(file, hash.value());
  return file;
}

void use(const Cloud& cloud) {
  if (cloud.empty()) return;
  require(cloud.massProperties().mass >= 0, "a negative mass");
  cloud.counts();
  const fs::path file = inputFolder() / "again.cloud";
  saveCloud(cloud, file);
  const Cloud again = loadCloud(file);
  require(again.counts().inside == cloud.counts().inside, "another cloud after saving");
  if (cloud.bricks().cast<std::int64_t>().prod() > 8) return;
  mayRefuse("SurfaceField", [&] { fieldOf(cloud); });
}

void use(const DigitalObject& object) {
  if (const Cloud* cloud = std::get_if<Cloud>(&object)) return use(*cloud);
  boundsOf(object);
  const fs::path file = inputFolder() / "again.cloud";
  mayRefuse("again.cloud", [&] { saveObject(object, file); });
}

void readCloud(std::string_view input) {
  const auto load = [](std::string_view bytes) {
    const fs::path file = inputFile("object.cloud", bytes);
    mayRefuse("object.cloud", [&] { use(loadObject(file)); });
    mayRefuse("object.cloud", [&] { loadCloud(file); });
  };
  load(input);
  load(sealed(input));
}

// What saveObject() writes, without its checksum.
std::string savedObject(const DigitalObject& object) {
  const fs::path file = inputFolder() / "seed.cloud";
  saveObject(object, file);
  std::string bytes = contentOf(file);
  bytes.resize(bytes.size() - 8);
  return bytes;
}

std::vector<std::string> seedsOfCloud() {
  const Cloud ball = smallBall(3), parts = twoParts();
  PointCloud points = surfacePoints(ball);
  points.positions.resize(40), points.normals.resize(40);
  SphereCloud spheres{{Vec3(0, 0, 0), Vec3(0.01, 0, 0)}, {0.01, 0.02}, {0, 1}, {"a", "b"}};
  DepthImage image{
      2, 2, {Vec3(0, 0, 1), Vec3(1, 0, 1), Vec3(0, 1, 1), Vec3(1, 1, 1)}, Vec3::Zero()};
  ColumnCloud columns = toColumns(smallBall(2), 2, 1);
  return {savedObject(ball),
          savedObject(parts),
          savedObject(points),
          savedObject(spheres),
          savedObject(image),
          savedObject(columns),
          savedObject(Octree(smallBall(2))),
          savedObject(SphereTree(spheres))};
}

// A cache whose entry is the input gives the cloud all the same, or that of an entry which is
// whole.
void readCache(std::string_view input) {
  const fs::path folder = inputFolder() / "cache";
  program::ShapeCache cache(folder);
  const Mesh mesh = cube(0.01);
  static const Cloud made = smallBall(3);
  static const auto field = fieldOf(made);
  const auto makeCloud = [] { return made; };
  const auto makeField = [] { return field; };
  cache.cloud(mesh, 1e-3, makeCloud);
  cache.field(made, makeField);
  for (const auto& entry : fs::directory_iterator(folder)) {
    std::ofstream out(entry.path(), std::ios::binary);
    const std::string bytes = sealed(input);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }
  const Cloud found = cache.cloud(mesh, 1e-3, makeCloud);
  bool whole = found.bricks() == made.bricks();
  mayRefuse("entry.cloud", [&] {
    const Cloud entry = loadCloud(inputFile("entry.cloud", sealed(input)));
    whole = whole || found.bricks() == entry.bricks();
  });
  require(whole, "no cloud from a cache");
  require(cache.field(made, makeField)->sampleCount() > 0, "no field from a cache");
  fs::remove_all(folder);
}

}  // namespace

Target cloudTarget() {
  return {"cloud", readCloud, seedsOfCloud, 1 << 16};
}
Target cacheTarget() {
  return {"cache", readCache, seedsOfCloud, 1 << 16};
}

}  // namespace cloudcontact::fuzz
