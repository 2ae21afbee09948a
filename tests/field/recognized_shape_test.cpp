// Which clouds are recognised as a shape, in any pose, size and resolution, and which are not.
#include <cloudcontact/field/recognized_shape.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>

#include "field/closed_form.h"
#include "field/mesh_field.h"
#include "law/hulls.h"
#include "mesh/test_meshes.h"
#include "mesh/turned_mesh.h"
#include "voxels/small_clouds.h"

namespace cloudcontact::testing::recognized_shape_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kSides = 256;  // a facet's sag is below 0.005 voxel

Mesh meshOf(const Solid& solid) {
  if (const auto* ball = std::get_if<Sphere>(&solid)) return test::sphereMesh(ball->radius, 6);
  if (const auto* box = std::get_if<Box>(&solid))
    return test::boxMesh(-box->halfExtents, box->halfExtents);
  if (const auto* c = std::get_if<Cylinder>(&solid))
    return test::cylinderMesh(c->radius, 2 * c->halfHeight, kSides);
  if (const auto* c = std::get_if<Capsule>(&solid))
    return test::capsuleMesh(c->radius, c->halfHeight, kSides);
  const auto& cone = std::get<Cone>(solid);
  return test::coneMesh(cone.radius, cone.halfHeight, kSides);
}

// Lengths in voxels, from a few voxels to 40 across.
struct RandomShapes {
  std::mt19937 random{7};
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  Solid solid(int kind) {
    const double size = between(6, 20);
    switch (kind) {
      case 0:
        return Sphere{size};
      case 1:
        return Box{size * Vec3(between(0.5, 1), between(0.5, 1), between(0.5, 1))};
      case 2:
        return Cylinder{size * between(0.4, 1), size * between(0.4, 1)};
      case 3:
        return Capsule{size * between(0.4, 0.7), size * between(0.3, 1)};
      default:
        return Cone{size * between(0.7, 1), size * between(0.7, 1), 0};
    }
  }
  Pose pose() {
    Pose p;
    p.orientation =
        Eigen::Quaterniond(between(-1, 1), between(-1, 1), between(-1, 1), between(-1, 1))
            .normalized();
    p.position = Vec3(between(-9, 9), between(-9, 9), between(-9, 9));
    return p;
  }
};

// The largest distance from points of one shape's surface to the other's, from a mesh's vertices.
double farthest(const Mesh& mesh, const PlacedSolid& shape) {
  double most = 0;
  for (const Vec3& v : mesh.vertices) most = std::max(most, std::abs(depthOf(shape, v)));
  return most;
}

class RecognizedKind : public ::testing::TestWithParam<int> {};

TEST_P(RecognizedKind, IsFoundInAnyPoseAndSize) {
  RandomShapes shapes;
  for (int trial = 0; trial < 12; ++trial) {
    const double voxel = std::pow(10, shapes.between(-5, -1));
    Solid solid = shapes.solid(GetParam());
    Mesh mesh = meshOf(solid);
    const Pose pose = shapes.pose();
    mesh = test::moved(mesh, pose.orientation, pose.position);
    for (Vec3& v : mesh.vertices) v *= voxel;
    const auto field = fieldOf(mesh, voxel);
    const auto found = recognizedShape(*field, 0.3 * voxel);
    ASSERT_TRUE(found) << trial;
    EXPECT_EQ(found->placed.solid.index(), solid.index());
    EXPECT_LE(found->error, 0.3 * voxel);
    EXPECT_LE(farthest(mesh, found->placed), 0.05 * voxel) << trial;
    EXPECT_TRUE(closedForm(*field)) << trial << ": the cloud's own error";
  }
}

// A cloud of what lies at a positive depth [voxels].
std::shared_ptr<const SurfaceField> bodyOf(const std::function<double(const Vec3&)>& depth,
                                           double voxel = 1e-3) {
  constexpr int kParts = 6;
  const Cloud cloud =
      test::smallCloud(voxel, Eigen::Vector3i::Constant(6), [&](int x, int y, int z) {
        const double middle = depth(Vec3(x, y, z) + Vec3::Constant(0.5));
        if (std::abs(middle) > 1) return middle > 0 ? 255 : 0;
        double sum = 0;
        for (int k = 0; k < kParts * kParts * kParts; ++k) {
          const Vec3 part(k % kParts, k / kParts % kParts, k / kParts / kParts);
          const Vec3 at = Vec3(x, y, z) + ((part.array() + 0.5) / kParts).matrix();
          sum += std::clamp(0.5 + kParts * depth(at), 0.0, 1.0);
        }
        return static_cast<int>(std::lround(255 * sum / (kParts * kParts * kParts)));
      });
  FieldSettings settings;
  settings.threads = 1;
  return SurfaceField::build(cloud, settings);
}

// Bodies in the middle of 48 voxels, turned.
const Pose kPlace{Eigen::Quaterniond(0.83, -0.31, 0.42, 0.19).normalized(), Vec3(23.7, 24.1, 24.4)};
const Solid kBox = Box{{12, 9, 10}}, kBall = Sphere{13}, kRod = Cylinder{10, 12};

double in(const Solid& solid, const Vec3& at, const Vec3& shift = Vec3::Zero()) {
  return solidAt(solid, kPlace.toLocal(at) - shift).depth;
}

struct Refused {
  const char* name;
  std::function<double(const Vec3&)> depth;
};

const Refused kRefused[] = {
    {"box with a notch at an edge",
     [](const Vec3& x) {
       return std::min(in(kBox, x), -in(Box{{3, 1.5, 1.5}}, x, {0, 9, 10}));
     }},
    {"box with a blind hole",
     [](const Vec3& x) {
       return std::min(in(kBox, x), -in(Cylinder{1.5, 4}, x, {3, 2, 10}));
     }},
    {"box that lacks a corner of two voxels",
     [](const Vec3& x) {
       return std::min(in(kBox, x), -in(Sphere{2}, x, {12, 9, 10}));
     }},
    {"box with a bump",
     [](const Vec3& x) {
       return std::max(in(kBox, x), in(Sphere{1.5}, x, {3, 2, 10}));
     }},
    {"dented ball",
     [](const Vec3& x) {
       return std::min(in(kBall, x), -in(Sphere{4}, x, {0, 0, 16}));
     }},
    {"ball with a hole inside",
     [](const Vec3& x) { return std::min(in(kBall, x), -in(Sphere{5}, x)); }},
    {"half a ball", [](const Vec3& x) { return std::min(in(kBall, x), -kPlace.toLocal(x).z()); }},
    {"tube",
     [](const Vec3& x) {
       return std::min(in(kRod, x), -in(Cylinder{5, 20}, x));
     }},
    {"box with a hole inside",
     [](const Vec3& x) { return std::min(in(kBox, x), -in(Sphere{4}, x)); }},
    {"hexagonal nut",
     [](const Vec3& x) {
       return std::min(in(test::prismHull(6, 12, 6), x), -in(Cylinder{5, 20}, x));
     }},
    {"hexagonal block with a round end",
     [](const Vec3& x) { return std::min(in(test::prismHull(6, 10, 12), x), in(Sphere{15}, x)); }},
    {"ellipsoid",
     [](const Vec3& x) {
       return in(Ellipsoid{{12, 13, 15}}, x);
     }},
    {"two balls",
     [](const Vec3& x) {
       return std::max(in(Sphere{6}, x, {8, 0, 0}), in(Sphere{6}, x, {-8, 0, 0}));
     }},
    {"ell",
     [](const Vec3& x) {
       return std::min(in(kBox, x), -in(Box{{12, 9, 10}}, x, {10, 9, 0}));
     }},
};

class RefusedBody : public ::testing::TestWithParam<Refused> {};

TEST_P(RefusedBody, IsNoShape) {
  EXPECT_FALSE(recognizedShape(*bodyOf(GetParam().depth), 0.4e-3)) << GetParam().name;
}

INSTANTIATE_TEST_SUITE_P(Bodies, RefusedBody, ::testing::ValuesIn(kRefused),
                         [](const auto& refused) {
                           std::string name = refused.param.name;
                           for (char& c : name)
                             if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
                           return name;
                         });

// A hole stays one however much a user can bear: its walls are as deep as the body is thick. Once a
// flat link of a chain became a box within three quarters of its wire's radius, and its neighbors
// were thrown out of the hole.
TEST(RecognizedShape, AHoleIsNeverFilled) {
  const std::function<double(const Vec3&)> bodies[] = {
      [](const Vec3& x) {
        return std::min(in(kRod, x), -in(Cylinder{5, 20}, x));
      },
      [](const Vec3& x) {
        return std::min(in(test::prismHull(6, 12, 6), x), -in(Cylinder{5, 20}, x));
      },
      [](const Vec3& x) { return std::min(in(kBall, x), -in(Sphere{8}, x)); },
      [](const Vec3& x) {  // a ring of wire
        const Vec3 p = kPlace.toLocal(x);
        return 4 - std::hypot(std::hypot(p.x(), p.y()) - 12, p.z());
      },
      [](const Vec3& x) {  // a long one
        const Vec3 p = kPlace.toLocal(x);
        const double along = p.x() - std::clamp(p.x(), -5.0, 5.0);
        return 3.5 - std::hypot(std::hypot(along, p.y()) - 9, p.z());
      }};
  for (const auto& depth : bodies) {
    const auto field = bodyOf(depth);
    for (const double tolerance : {0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 10.0, 20.0})
      EXPECT_FALSE(recognizedShape(*field, 1e-3 * tolerance)) << tolerance;
  }
}

TEST(RecognizedShape, ErrorIsThatOfTheBody) {
  // A ball whose radius varies by 0.25 voxel, and a box with an edge that lacks 0.5 voxel.
  const auto oval = bodyOf([](const Vec3& x) {
    const Vec3 p = kPlace.toLocal(x);
    return 13 - 0.25 * (1.5 * p.z() * p.z() / p.squaredNorm() - 0.5) - p.norm();
  });
  const auto asBall = recognizedShape(*oval, 0.5e-3);
  ASSERT_TRUE(asBall);
  EXPECT_GE(asBall->error, 0.16e-3);
  EXPECT_LE(asBall->error, 0.28e-3);
  EXPECT_FALSE(recognizedShape(*oval, 0.1e-3));
  const auto blunt = bodyOf([](const Vec3& x) {
    const Vec3 n = Vec3(1, 1, 0) / std::sqrt(2.0);
    return std::min(in(kBox, x), 21 / std::sqrt(2.0) - 0.5 - n.dot(kPlace.toLocal(x)));
  });
  const auto asBox = recognizedShape(*blunt, 1e-3);
  ASSERT_TRUE(asBox);
  EXPECT_GE(asBox->error, 0.4e-3);
  EXPECT_LE(asBox->error, 0.6e-3);
  // It is no box to 0.3 voxel, but a hull with that face.
  const auto asHull = recognizedShape(*blunt, 0.3e-3);
  EXPECT_TRUE(!asHull || std::get<Hull>(asHull->placed.solid).planes.size() == 7);
}

TEST(RecognizedShape, ToleranceMustBeANumberOfMeters) {
  const auto field = bodyOf([](const Vec3& x) { return in(kBall, x); });
  EXPECT_THROW(recognizedShape(*field, -1), std::invalid_argument);
  EXPECT_THROW(recognizedShape(*field, std::nan("")), std::invalid_argument);
  EXPECT_FALSE(recognizedShape(*field, 0));
}

// Convex bodies with flat faces, lengths in voxels.
struct Flat {
  const char* name;
  Hull hull;
};

std::vector<HalfSpace> regular(const std::vector<Vec3>& ways, double inner) {
  std::vector<HalfSpace> planes;
  for (const Vec3& way : ways) planes.push_back(test::facing(way, inner));
  return planes;
}

Hull withPlane(Hull hull, const HalfSpace& plane) {
  hull.planes.push_back(plane);
  return test::hullOf(hull.planes);
}

std::vector<Flat> flatBodies() {
  const double golden = (1 + std::sqrt(5.0)) / 2;
  std::vector<Vec3> eight, twelve;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0}) {
      for (const double z : {-1.0, 1.0}) eight.emplace_back(x, y, z);
      for (int axis = 0; axis < 3; ++axis) {
        Vec3 way = Vec3::Zero();
        way[axis] = x;
        way[(axis + 1) % 3] = y * golden;
        twelve.push_back(way);
      }
    }
  const Hull box = test::boxHull({12, 9, 10});
  std::vector<Flat> bodies = {
      {"tetrahedron", test::hullOf(regular({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}, 7))},
      {"octahedron", test::hullOf(regular(eight, 10))},
      {"dodecahedron", test::hullOf(regular(twelve, 14))},
      {"hexagonal prism", test::prismHull(6, 12, 6)},
      {"prism of nine sides", test::prismHull(9, 17, 10)},
      {"box that lacks an edge of 1.5 voxels",
       withPlane(box, test::facing({1, 1, 0}, (21 - 1.5) / std::sqrt(2.0)))},
      {"box that lacks an edge", withPlane(box, test::facing({1, 1, 0}, 16 / std::sqrt(2.0)))},
      {"box that lacks a corner", withPlane(box, test::facing({1, 1, 1}, 23 / std::sqrt(3.0)))},
      {"roof", withPlane(box, test::facing({1, 0, 1}, 3))},
  };
  std::mt19937 random(5);
  for (int trial = 0; trial < 4; ++trial)
    bodies.push_back({"of random planes", test::randomHull(6 + 3 * trial, 15, random)});
  return bodies;
}

double areaOf(const Hull& hull, const std::vector<int>& face, const Vec3& normal) {
  Vec3 twice = Vec3::Zero();
  for (std::size_t i = 0; i < face.size(); ++i)
    twice += hull.corners[static_cast<std::size_t>(face[i])].cross(
        hull.corners[static_cast<std::size_t>(face[(i + 1) % face.size()])]);
  return twice.dot(normal) / 2;
}

// The found hull has the body's faces, each by its place, and no others. The tolerance may leave
// out one of a few voxels.
void expectFaces(const Flat& body, const Pose& pose, const PlacedSolid& found) {
  const Hull& hull = std::get<Hull>(found.solid);
  std::size_t left = 0;
  EXPECT_EQ(hull.corners.size() + hull.planes.size(), hull.edges.size() + 2) << body.name;
  for (const HalfSpace& plane : body.hull.planes) {
    Vec3 middle = Vec3::Zero();
    const auto on = test::cornersOn(body.hull, plane);
    const bool small = areaOf(body.hull, on, plane.normal) < 20;
    for (const int i : on) middle += body.hull.corners[static_cast<std::size_t>(i)];
    const Vec3 at = pose.toWorld(middle / static_cast<double>(on.size()));
    const Vec3 normal = pose.orientation * plane.normal;
    const bool is = std::any_of(hull.planes.begin(), hull.planes.end(), [&](const HalfSpace& p) {
      const Vec3 n = found.place.orientation * p.normal;
      return n.dot(normal) > std::cos(0.02) &&
             std::abs(p.offset - n.dot(at - found.place.position)) < 0.05;
    });
    EXPECT_TRUE(is || small) << body.name << ": " << plane.normal.transpose();
    left += !is;
  }
  EXPECT_EQ(hull.planes.size() + left, body.hull.planes.size()) << body.name;
}

TEST(RecognizedShape, FlatConvexBodiesAreHulls) {
  RandomShapes shapes;
  for (const Flat& body : flatBodies()) {
    const Pose pose = shapes.pose();
    const Mesh mesh = test::moved(test::meshOf(body.hull), pose.orientation, pose.position);
    const auto found = recognizedShape(*fieldOf(mesh, 1), 0.45);
    ASSERT_TRUE(found) << body.name;
    ASSERT_STREQ(shapeName(found->placed.solid), "hull") << body.name;
    expectFaces(body, pose, found->placed);
    EXPECT_LE(farthest(mesh, found->placed), 0.15) << body.name;
    EXPECT_LE(found->error, 0.45) << body.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, RecognizedKind, ::testing::Range(0, 5));

}  // namespace
}  // namespace cloudcontact::testing::recognized_shape_test
