// Convex bodies, which every method can do. B lies on A, so the force on B is along +z.
#include <numbers>

#include "lab/case_bodies.h"

namespace cloudcontact::program::lab {
namespace {

constexpr double kSize = 0.01;  // [m]
const Vec3 kSlab(0.03, 0.028, 0.008);

LabBody slab(Random& random) {
  return primitiveBody("slab", Box{kSlab / 2}, random);
}
// B's pose, pressed by `depth` into the slab's top; B's lowest point is `below` its origin.
std::function<Pose(double)> onSlab(double below, const Eigen::Quaterniond& turn, double x = 0,
                                   double y = 0) {
  return [=](double depth) { return at(x, y, kSlab.z() / 2 + below - depth, turn); };
}
Truth upward(const Vec3& center = Vec3::Zero()) {
  return {Vec3::UnitZ(), 0.0, center, {}};
}

Instance sphereOnPlane(std::uint64_t seed) {
  Random random(seed);
  LabBody ball = primitiveBody("sphere", Sphere{kSize}, random);
  return {halfSpaceBody(), ball,
          pressed(
              depthsOf(kSize), [](double d) { return at(0, 0, kSize - d); }, upward())};
}

Instance sphereOnSphere(std::uint64_t seed) {
  Random random(seed);
  LabBody a = primitiveBody("sphere", Sphere{kSize}, random);
  LabBody b = primitiveBody("sphere", Sphere{kSize}, random);
  return {a, b,
          pressed(
              depthsOf(kSize), [](double d) { return at(0, 0, 2 * kSize - d); }, upward())};
}

Instance cylinderSide(std::uint64_t seed) {
  Random random(seed);
  LabBody a = slab(random), b = primitiveBody("cylinder", Cylinder{kSize, kSize}, random);
  const auto turn = turnZ(random.uniform(0, 3)) * turnY(std::numbers::pi / 2);
  return {a, b, pressed(depthsOf(kSize), onSlab(kSize, turn), upward())};
}

Instance cylinderEnd(std::uint64_t seed) {
  Random random(seed);
  LabBody a = slab(random), b = primitiveBody("cylinder", Cylinder{kSize, kSize}, random);
  return {a, b,
          pressed(depthsOf(kSize), onSlab(kSize, turnZ(0.3), 0.001, -0.001),
                  upward({0.001, -0.001, 0}))};
}

LabBody box(Random& random) {
  return primitiveBody("box", Box{Vec3(1, 0.8, 0.9) * kSize}, random);
}
const Vec3 kHalf = Vec3(1, 0.8, 0.9) * kSize;

Instance boxFace(std::uint64_t seed) {
  Random random(seed);
  LabBody a = slab(random), b = box(random);
  return {a, b,
          pressed(depthsOf(kSize), onSlab(kHalf.z(), turnZ(0.4), 1e-3), upward({1e-3, 0, 0}))};
}

Instance boxEdge(std::uint64_t seed) {
  Random random(seed);
  LabBody a = slab(random), b = box(random);
  const double roll = random.uniform(0.35, 1.2);
  const auto turn = turnZ(random.uniform(0, 3)) * turnX(roll);
  const Vec3 lowest = turn * Vec3(0, -kHalf.y(), -kHalf.z());
  Truth truth = upward();
  truth.center = {};  // lies beside the edge by a share of the depth that the law decides
  return {a, b,
          pressed(depthsOf(kSize), onSlab(-lowest.z(), turn, -lowest.x(), -lowest.y()), truth)};
}

Instance boxCorner(std::uint64_t seed) {
  Random random(seed);
  LabBody a = slab(random), b = box(random);
  Eigen::Quaterniond turn;
  do turn = random.rotation();
  while ((turn.toRotationMatrix().row(2).array().abs() < 0.26).any());
  Vec3 lowest = Vec3::Zero();
  for (int k = 0; k < 8; ++k) {
    const Vec3 sign(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
    const Vec3 corner = turn * sign.cwiseProduct(kHalf).eval();
    if (corner.z() < lowest.z()) lowest = corner;
  }
  Truth truth = upward();
  truth.center = {};
  return {a, b,
          pressed(depthsOf(kSize), onSlab(-lowest.z(), turn, -lowest.x(), -lowest.y()), truth)};
}

// Both boxes rolled by 45 degrees, their edges at right angles.
Instance crossedEdges(std::uint64_t seed) {
  Random random(seed);
  const Box cube{Vec3(1, 1, 1) * kSize};
  LabBody a = primitiveBody("box", cube, random), b = primitiveBody("box", cube, random);
  const double up = std::numbers::sqrt2 * kSize;
  // A is at the origin, not rotated; in its frame up is (0, 1, 1).
  const Eigen::Quaterniond seen = turnX(-std::numbers::pi / 4);
  Truth truth = upward();
  truth.direction = seen * Vec3::UnitZ();
  truth.center = seen * Vec3(0, 0, up);
  const auto turn = turnZ(std::numbers::pi / 2) * turnX(std::numbers::pi / 4);
  return {a, b,
          pressed(
              depthsOf(kSize),
              [=](double d) {
                return Pose{seen * turn, seen * Vec3(0, 0, 2 * up - d)};
              },
              truth)};
}

Instance overhang(std::uint64_t seed) {
  Random random(seed);
  LabBody a = slab(random), b = box(random);
  const double beyond = 0.4 * kSize;  // distance of B's middle past A's edge
  const double x = kSlab.x() / 2 + beyond;
  const double from = x - kHalf.x(), to = kSlab.x() / 2;
  return {
      a, b,
      pressed(depthsOf(kSize), onSlab(kHalf.z(), turnZ(0), x), upward({(from + to) / 2, 0, 0}))};
}

// Deeper than the fields' band: 2, 5 and 10 voxels of size / 32.
std::vector<double> deep() {
  return {2 * kSize / 32, 5 * kSize / 32, 10 * kSize / 32};
}

Instance sphereDeep(std::uint64_t seed) {
  Random random(seed);
  LabBody b = primitiveBody("sphere", Sphere{kSize}, random);
  LabBody a = primitiveBody("block", Box{Vec3(1.6, 1.6, 1) * kSize}, random);
  return {a, b,
          pressed(
              deep(), [](double d) { return at(0, 0, 2 * kSize - d); }, upward())};
}

Instance boxDeep(std::uint64_t seed) {
  Random random(seed);
  LabBody a = primitiveBody("block", Box{Vec3(1.6, 1.6, 1) * kSize}, random), b = box(random);
  return {
      a, b,
      pressed(
          deep(), [](double d) { return at(0, 0, kSize + kHalf.z() - d, turnZ(0.5)); }, upward())};
}

}  // namespace

std::vector<LabCase> convexCases() {
  return {{"smooth", "sphere on plane", true, true, kSize, true, sphereOnPlane},
          {"smooth", "sphere on sphere", true, true, kSize, true, sphereOnSphere},
          {"smooth", "cylinder's side on a face", true, true, kSize, true, cylinderSide},
          {"flat", "cylinder's end on a face", true, false, kSize, false, cylinderEnd},
          {"flat", "box's face on a face", true, false, kSize, true, boxFace},
          {"flat", "face overhanging an edge", true, false, kSize, true, overhang},
          {"edges", "box's edge on a face", true, false, kSize, true, boxEdge},
          {"edges", "box's corner on a face", true, false, kSize, true, boxCorner},
          {"edges", "crossed edges", true, false, kSize, true, crossedEdges},
          {"deep", "sphere deep in a block", true, false, kSize, true, sphereDeep},
          {"deep", "box deep in a block", true, false, kSize, false, boxDeep}};
}

}  // namespace cloudcontact::program::lab
