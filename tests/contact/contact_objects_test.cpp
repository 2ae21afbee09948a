// One ball and one nut in every digital kind: as object 1 and as object 2, against a half-space, a
// box and a ball, all give the normal and the force of the ideal solid.
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/mesh/mesh_file.h>
#include <cloudcontact/objects/digital_object.h>
#include <cloudcontact/objects/object_file.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>

#include "objects/test_objects.h"

namespace cloudcontact {
namespace {

using namespace test;

constexpr double kStiffness = 1e4;            // [N/m]
constexpr double kNormal = 1, kForce = 0.02;  // bounds: degrees, share of k d
constexpr double kDepth = 1;                  // voxels

// A solid known by its voxels, and where it is pressed: `at` on its surface, looking along `out`.
struct Specimen {
  Cloud cloud;
  Vec3 at, out;
  double ball;  // radius of the ball that presses it [voxels]
  double box;   // half the edge of the box that does
  std::function<double(const Vec3& from, const Vec3& ray)> seen;  // distance along a ray; NaN: none
};

Specimen theBall() {
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

// 44 voxels across flats, hole 20, 12 high; turned against its grid. Pressed on its face, the ball
// and the box in the middle of the ring beside a flat.
Specimen theNut() {
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

// What a camera before `at` sees, a third of a voxel from pixel to pixel.
DepthImage photographed(const Specimen& solid) {
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

PointCloud bare(PointCloud points) {
  points.normals.clear();
  return points;
}

struct Kind {
  const char* name;
  std::function<Cloud(const Specimen&)> make;
};
// How gtest names a kind in a failure.
void PrintTo(const Kind& kind, std::ostream* out) {
  *out << kind.name;
}

// Lossless kinds as they are; lossy ones as dense as it takes, which is told beside them.
std::vector<Kind> kinds() {
  const auto by = [](auto make) {
    return [make](const Specimen& s) { return toCloud(DigitalObject(make(s.cloud)), kH); };
  };
  return {
      {"voxels", [](const Specimen& s) { return s.cloud; }},
      {"octree", by([](const Cloud& c) { return Octree(c); })},
      {"columnsX", by([](const Cloud& c) { return toColumns(c, 0, 4); })},
      {"columnsZ", by([](const Cloud& c) { return toColumns(c, 2, 1); })},
      {"voxelCentres", by([](const Cloud& c) { return centerPoints(c); })},
      {"partsOfVoxels", by([](const Cloud& c) { return centerPoints(c, 3); })},
      {"voxelCorners", by([](const Cloud& c) { return cornerPoints(c); })},
      {"treeOfVoxels", by([](const Cloud& c) { return SphereTree(c); })},
      {"treeOfPoints", by([](const Cloud& c) { return SphereTree(centerPoints(c)); })},
      // A scan of 9 points a voxel face; its edges are rounded over a voxel.
      {"scan", by([](const Cloud& c) { return bare(surfacePoints(c, 3)); })},
      {"scanWithNormals", by([](const Cloud& c) { return surfacePoints(c, 3); })},
      // Spheres that leave at most 0.02 voxel of the surface uncovered.
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
      // One side, three pixels a voxel; closed 8 voxels behind.
      {"depthImage",
       [](const Specimen& s) {
         DepthCloudSettings settings;
         settings.voxelSize = kH;
         settings.thickness = 8 * kH;
         settings.backing = Backing::Rays;
         settings.image.jump = 2 * kH;
         return toCloud(photographed(s), settings);
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

// What presses the solid by kDepth voxels.
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
  plane.orientation = box.orientation =
      Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), Vec3(-s.out));
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

// Made once a solid.
const std::vector<Presser>& pressers(const Specimen& s) {
  static std::map<const Specimen*, std::vector<Presser>> made;
  std::vector<Presser>& found = made[&s];
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
  const double off = force.norm() / (kStiffness * kDepth * kH) - 1;
  EXPECT_LE(degrees, kNormal);
  EXPECT_LE(std::abs(off), kForce) << off;
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
  static const Specimen solid = theBall();
  pressOnAll(solid, GetParam().make(solid));
}

TEST_P(ContactObjects, NutIsTheSame) {
  static const Specimen solid = theNut();
  pressOnAll(solid, GetParam().make(solid));
}

// The real M16 nut in voxels of 0.4 mm, pressed on its bearing face, in the middle of the ring
// beside a flat. Told as if its voxels were kH: contact does not know the size.
Specimen theRealNut(const std::filesystem::path& file) {
  Mesh mesh = loadMesh(file);
  Eigen::AlignedBox3d box;
  for (const Vec3& v : mesh.vertices) box.extend(v);
  const double scale = kH / 0.4e-3;
  for (Vec3& v : mesh.vertices) v = oddTurn() * (scale * (v - box.center()));
  Specimen solid{digitized(mesh), {}, {}, 8, 3, {}};
  solid.out = oddTurn() * -Vec3::UnitZ();
  solid.at = oddTurn() * (scale * Vec3(10.15e-3, 0, -0.5 * box.sizes()[2]));
  return solid;
}

// A kind that gives the voxels back is pressed above; here one of them, and those that lose some.
class RealContactObjects : public ::testing::TestWithParam<Kind> {};

TEST_P(RealContactObjects, NutIsTheSame) {
  const std::filesystem::path file =
      std::filesystem::path(CLOUDCONTACT_SHARED_DIR) / "data" / "nut_m16_loose.obj";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not here";
  const Specimen solid = theRealNut(file);
  pressOnAll(solid, GetParam().make(solid));
}

std::vector<Kind> realKinds() {
  std::vector<Kind> some;
  for (const Kind& kind : kinds())
    for (const char* name : {"octree", "partsOfVoxels", "voxelCorners", "scan", "spheres"})
      if (kind.name == std::string(name)) some.push_back(kind);
  return some;
}

INSTANTIATE_TEST_SUITE_P(Kinds, RealContactObjects, ::testing::ValuesIn(realKinds()),
                         [](const auto& param) { return std::string(param.param.name); });
INSTANTIATE_TEST_SUITE_P(Kinds, ContactObjects, ::testing::ValuesIn(kinds()),
                         [](const auto& param) { return std::string(param.param.name); });

}  // namespace
}  // namespace cloudcontact
