// A ball and a nut in every kind of digital object, as object 1 and as object 2, pressed by a
// half-space, a box and a ball. All give the normal and force of the ideal solid.
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/objects/digital_object.h>
#include <cloudcontact/objects/object_file.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>

#include "mesh/thread_meshes.h"
#include "objects/test_objects.h"

namespace cloudcontact::contact_objects_test {
namespace {

using namespace test;

constexpr double kStiffness = 1e4;            // [N/m]
constexpr double kNormal = 1, kForce = 0.02;  // bounds: degrees, relative error of k d
constexpr double kDepth = 1;                  // voxels

// A solid and the point of its surface where it is pressed.
struct Specimen {
  Cloud cloud;
  Vec3 at, out;  // the point and the outward normal there
  double ball;   // radius of the ball that presses it [voxels]
  double box;    // half the edge of the box that presses it [voxels]
  // Distance to the solid along a ray; NaN: the ray misses it.
  std::function<double(const Vec3& from, const Vec3& ray)> seen;
};

Specimen ballSolid() {
  const double r = 14;
  Specimen solid{ballCloud(r), {}, {}, 10, 12, {}};
  solid.out = Vec3(0.3, -0.5, 0.8).normalized();
  solid.at = ballMiddle() + r * kH * solid.out;
  solid.seen = [r](const Vec3& from, const Vec3& ray) {
    const Vec3 to = from - ballMiddle();
    const double b = to.dot(ray), c = to.squaredNorm() - r * r * kH * kH;
    return b * b < c ? NAN : -b - std::sqrt(b * b - c);
  };
  return solid;
}

// 44 voxels across flats, hole 20, 12 high, turned against its grid. Pressed on its face, halfway
// between the hole and a flat.
Specimen nutSolid() {
  const double width = 44.3 * kH, hole = 20.6 * kH, height = 12.4 * kH;
  Specimen solid{
      digitized(moved(nutMesh(width, hole, height), oddTurn(), ballMiddle())), {}, {}, 10, 3, {}};
  const double ring = 0.25 * (width + hole);
  solid.out = oddTurn() * Vec3::UnitZ();
  solid.at = oddTurn() * Vec3(ring, 0, 0.5 * height) + ballMiddle();
  solid.seen = [=](const Vec3& from, const Vec3& ray) {
    const Vec3 x = oddTurn().conjugate() * (from - ballMiddle()), d = oddTurn().conjugate() * ray;
    const double far = (0.5 * height - x[2]) / d[2];
    const Vec3 hit = x + far * d;
    double across = 0;
    for (int k = 0; k < 6; ++k)
      across = std::max(across, hit[0] * std::cos(k * std::numbers::pi / 3) +
                                    hit[1] * std::sin(k * std::numbers::pi / 3));
    return far > 0 && across < 0.5 * width && hit.head<2>().norm() > 0.5 * hole ? far : NAN;
  };
  return solid;
}

// The image of a camera in front of `at`, with pixels a third of a voxel apart.
DepthImage depthImage(const Specimen& solid) {
  DepthImage image;
  image.width = image.height = 221;
  const Vec3 t1 = solid.out.unitOrthogonal(), t2 = solid.out.cross(t1);
  image.viewpoint = solid.at + 200 * kH * solid.out;
  for (int k = 0; k < image.width * image.height; ++k) {
    const Vec3 target = solid.at + kH / 3 * ((k % 221 - 110) * t1 + (k / 221 - 110) * t2);
    const Vec3 ray = (target - image.viewpoint).normalized();
    image.points.push_back(image.viewpoint + solid.seen(image.viewpoint, ray) * ray);
  }
  return image;
}

PointCloud withoutNormals(PointCloud points) {
  points.normals.clear();
  return points;
}

struct Kind {
  const char* name;
  std::function<Cloud(const Specimen&)> make;
};
// A kind's name in gtest's messages.
void PrintTo(const Kind& kind, std::ostream* out) {
  *out << kind.name;
}

// Lossless kinds with default settings; lossy ones as dense as the bounds require.
std::vector<Kind> kinds() {
  const auto by = [](auto make) {
    return [make](const Specimen& s) { return toCloud(DigitalObject(make(s.cloud)), kH); };
  };
  return {
      {"voxels", [](const Specimen& s) { return s.cloud; }},
      {"octree", by([](const Cloud& c) { return Octree(c); })},
      {"columnsX", by([](const Cloud& c) { return toColumns(c, 0, 4); })},
      {"columnsZ", by([](const Cloud& c) { return toColumns(c, 2, 1); })},
      {"voxelCenters", by([](const Cloud& c) { return centerPoints(c); })},
      {"partsOfVoxels", by([](const Cloud& c) { return centerPoints(c, 3); })},
      {"voxelCorners", by([](const Cloud& c) { return cornerPoints(c); })},
      {"treeOfVoxels", by([](const Cloud& c) { return SphereTree(c); })},
      {"treeOfPoints", by([](const Cloud& c) { return SphereTree(centerPoints(c)); })},
      // 9 points per voxel face. Edges are rounded over a voxel.
      {"scan", by([](const Cloud& c) { return withoutNormals(surfacePoints(c, 3)); })},
      {"scanWithNormals", by([](const Cloud& c) { return surfacePoints(c, 3); })},
      // Spheres within 0.02 voxel of the surface.
      {"spheres", by([](const Cloud& c) {
         InscribedSettings settings;
         settings.tolerance = 0.02;
         return inscribedSpheres(c, settings);
       })},
      {"treeOfSpheres", by([](const Cloud& c) {
         InscribedSettings settings;
         settings.tolerance = 0.02;
         return SphereTree(inscribedSpheres(c, settings));
       })},
      // One side, three pixels per voxel, closed 8 voxels behind.
      {"depthImage",
       [](const Specimen& s) {
         DepthCloudSettings settings;
         settings.voxelSize = kH;
         settings.thickness = 8 * kH;
         settings.backing = Backing::Rays;
         settings.image.jump = 2 * kH;
         return toCloud(depthImage(s), settings);
       }},
      {"otherVoxels", [](const Specimen& s) { return resampled(s.cloud, 0.8 * kH); }},
      {"saved",
       [](const Specimen& s) {
         const std::filesystem::path file =
             std::filesystem::temp_directory_path() /
             ("cloudcontact_objects_" + std::to_string(reinterpret_cast<std::uintptr_t>(&s)) +
              ".cloud");
         saveObject(toColumns(s.cloud, 1, 2), file);
         const Cloud cloud = toCloud(loadObject(file), kH);
         std::filesystem::remove(file);
         return cloud;
       }},
  };
}

// A body that presses the solid by kDepth voxels.
struct Presser {
  std::string name;
  std::shared_ptr<const SurfaceField> field;
  std::optional<Solid> shape;
  Pose pose;
};

std::vector<Presser> makePressers(const Specimen& s) {
  const double r = s.ball * kH, half = s.box * kH;
  const Vec3 touch = s.at - kDepth * kH * s.out;
  Pose plane, box, ball;
  plane.position = touch;
  plane.orientation = box.orientation = shortestTurn(Vec3::UnitZ(), Vec3(-s.out));
  box.position = touch + half * s.out;
  ball.position = touch + r * s.out;
  Pose ballCloudPose = ball;
  ballCloudPose.position -= ballMiddle();
  return {{"halfspace", nullptr, HalfSpace{}, plane},
          {"boxShape", nullptr, Box{Vec3::Constant(half)}, box},
          {"boxCloud",
           SurfaceField::build(digitized(boxMesh(Vec3::Constant(-half), Vec3::Constant(half)))),
           {},
           box},
          {"ballShape", nullptr, Sphere{r}, ball},
          {"ballCloud", SurfaceField::build(ballCloud(s.ball)), {}, ballCloudPose}};
}

// Cached for each solid.
const std::vector<Presser>& pressers(const Specimen& s) {
  static std::map<const Specimen*, std::vector<Presser>> cache;
  std::vector<Presser>& found = cache[&s];
  if (found.empty()) found = makePressers(s);
  return found;
}

// The solid is object 1 (A) or object 2 (B).
void expectContact(const Specimen& s, const SurfaceField& field, const Presser& presser,
                   bool first) {
  ContactBody solid, other;
  solid.field = &field;
  other.field = presser.field.get();
  other.shape = presser.shape ? &*presser.shape : nullptr;
  other.pose = presser.pose;
  ContactSettings settings;
  settings.law = KelvinVoigt{kStiffness, 0};
  ContactFinder finder;
  const ContactResult& found =
      first ? finder.find(solid, other, settings) : finder.find(other, solid, settings);
  const Vec3 force = wrenchOnB(found, {}, {}).force, out = first ? s.out : Vec3(-s.out);
  ASSERT_GT(force.norm(), 0);
  const double degrees =
      180 / std::numbers::pi * std::atan2(force.cross(out).norm(), force.dot(out));
  const double error = force.norm() / (kStiffness * kDepth * kH) - 1;
  EXPECT_LE(degrees, kNormal);
  EXPECT_LE(std::abs(error), kForce) << error;
}

class ContactObjects : public ::testing::TestWithParam<Kind> {};

void pressOnAll(const Specimen& solid, const Cloud& cloud) {
  const auto field = SurfaceField::build(cloud);
  for (const Presser& presser : pressers(solid))
    for (const bool first : {true, false}) {
      SCOPED_TRACE(presser.name + (first ? ", the solid first" : ", the solid second"));
      expectContact(solid, *field, presser, first);
    }
}

TEST_P(ContactObjects, BallIsTheSame) {
  static const Specimen solid = ballSolid();
  pressOnAll(solid, GetParam().make(solid));
}

TEST_P(ContactObjects, NutIsTheSame) {
  static const Specimen solid = nutSolid();
  pressOnAll(solid, GetParam().make(solid));
}

// An M16 nut with its thread, round outside, in voxels of 0.4 mm. Pressed on its upper face,
// halfway between the thread and the outside. Scaled to voxels of kH.
Specimen threadedNut() {
  constexpr double kOuter = 12e-3, kPlay = 0.15e-3, kHeight = 12.8e-3;
  const Thread thread;
  Mesh mesh = threadedRing(thread, kHeight, kOuter, kPlay);
  const double scale = kH / 0.4e-3;
  for (Vec3& v : mesh.vertices) v = oddTurn() * (scale * v);
  Specimen solid{digitized(mesh), {}, {}, 8, 3, {}};
  solid.out = oddTurn() * Vec3::UnitZ();
  solid.at = oddTurn() * (scale * Vec3((thread.radius + kPlay + kOuter) / 2, 0, 0.5 * kHeight));
  return solid;
}

// The simple solids cover all kinds; here one lossless kind and those that lose detail.
class ThreadedContactObjects : public ::testing::TestWithParam<Kind> {};

TEST_P(ThreadedContactObjects, NutIsTheSame) {
  static const Specimen solid = threadedNut();
  pressOnAll(solid, GetParam().make(solid));
}

std::vector<Kind> threadedKinds() {
  std::vector<Kind> some;
  for (const Kind& kind : kinds())
    for (const char* name : {"octree", "partsOfVoxels", "voxelCorners", "scan", "spheres"})
      if (kind.name == std::string(name)) some.push_back(kind);
  return some;
}

INSTANTIATE_TEST_SUITE_P(Kinds, ThreadedContactObjects, ::testing::ValuesIn(threadedKinds()),
                         [](const auto& param) { return std::string(param.param.name); });
INSTANTIATE_TEST_SUITE_P(Kinds, ContactObjects, ::testing::ValuesIn(kinds()),
                         [](const auto& param) { return std::string(param.param.name); });

}  // namespace
}  // namespace cloudcontact::contact_objects_test
