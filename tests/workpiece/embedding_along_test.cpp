// Embedding along the digital normal: tools of all shapes in a flat block, whose depth and force
// are known, and in holes of their own shape.
#include <gtest/gtest.h>

#include <cloudcontact/workpiece/cloud_solid.h>
#include <cloudcontact/workpiece/haptic_loop.h>

#include <cmath>
#include <numbers>
#include <string>

#include "law/solid_line.h"
#include "voxels/small_clouds.h"
#include "workpiece/embedding_along.h"

namespace cloudcontact::embedding_along_test {
namespace {

constexpr double kVoxel = 1e-4;  // [m]
constexpr double kTop = 32.3;    // of the block [voxels]

Vec3 up(double tilt) {
  return Eigen::AngleAxisd(tilt, Vec3(1, 2, 0).normalized()) * Vec3::UnitZ();
}

// A block whose top is the plane `normal` . x = kTop through the middle.
Cloud block(const Vec3& normal) {
  return test::smallCloud(kVoxel, {8, 8, 6}, [=](int x, int y, int z) {
    int in = 0;
    const Vec3 low(x - 32, y - 32, z);
    const double offset = kTop * normal.z(), middle = normal.dot(low + Vec3::Constant(.5)) - offset;
    if (middle < -0.9) return 255;
    if (middle > 0.9) return 0;
    for (int k = 0; k < 4096; ++k)
      in += normal.dot(low + Vec3(k % 16 + .5, k / 16 % 16 + .5, k / 256 + .5) / 16) < offset;
    return (in * 255 + 2048) / 4096;
  });
}

struct Tool {
  std::string name;
  Solid solid;              // lengths in voxels
  Eigen::Quaterniond turn;  // that the tip points along -z
};

Eigen::Quaterniond about(const Vec3& axis, double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis.normalized()));
}

std::vector<Tool> tools() {
  const auto none = Eigen::Quaterniond::Identity();
  const Eigen::Quaterniond edge = about(Vec3::UnitX(), std::numbers::pi / 4);
  const Eigen::Quaterniond corner = shortestTurn(Vec3(1, 1, 1), -Vec3::UnitZ());
  const Eigen::Quaterniond over = about(Vec3::UnitX(), std::numbers::pi);
  const Vec3 aside(1, 0.3, 0);
  return {{"needle", Cylinder{1.5, 12}, none},
          {"thin needle", Cylinder{0.6, 12}, none},
          {"leaning needle", Cylinder{1.5, 12}, about(aside, 0.35)},
          {"round needle", Capsule{1.2, 10}, none},
          {"leaning round needle", Capsule{1.2, 10}, about(aside, 0.6)},
          {"cone", Cone{4, 10, 0}, over},
          {"sharp cone", Cone{2, 8, 0}, over},
          {"leaning cone", Cone{4, 10, 0}, about(aside, 0.2) * over},
          {"blade", Box{Vec3(8, 1, 10)}, none},
          {"leaning blade", Box{Vec3(8, 1, 10)}, about(aside, 0.3)},
          {"blade's corner", Box{Vec3(8, 1, 10)}, about(Vec3(0.2, 1, 0), 0.5)},
          {"box corner", Box{Vec3(7, 7, 7)}, corner},
          {"box edge", Box{Vec3(8, 7, 7)}, edge},
          {"leaning edge", Box{Vec3(8, 7, 7)}, about(Vec3(0.1, 1, 0), 0.1) * edge},
          {"box face", Box{Vec3(6, 5, 7)}, none},
          {"leaning box 0.1", Box{Vec3(6, 5, 7)}, about(Vec3(0.1, 1, 0), 0.1)},
          {"leaning box 0.3", Box{Vec3(6, 5, 7)}, about(Vec3(0.5, 1, 0), 0.3)},
          {"leaning box 0.6", Box{Vec3(6, 5, 7)}, about(Vec3(0, 1, 0), 0.6)},
          {"far leaning needle", Capsule{1.2, 10}, about(aside, 1)},
          {"small ball", Sphere{4}, none},
          {"ball", Sphere{8}, none},
          {"ellipsoid", Ellipsoid{Vec3(9, 3, 12)}, about(Vec3(1, 1, 0), 0.4)}};
}

Solid scaled(Solid s) {
  std::visit(
      [](auto& k) {
        using T = std::decay_t<decltype(k)>;
        if constexpr (std::is_same_v<T, Sphere>)
          k.radius *= kVoxel;
        else if constexpr (std::is_same_v<T, Box>)
          k.halfExtents *= kVoxel;
        else if constexpr (std::is_same_v<T, Ellipsoid>)
          k.semiAxes *= kVoxel;
        else if constexpr (std::is_same_v<T, Capsule> || std::is_same_v<T, Cylinder> ||
                           std::is_same_v<T, Cone>)
          k.radius *= kVoxel, k.halfHeight *= kVoxel;
      },
      s);
  return s;
}

// The solid in voxels of half the workpiece's size, turned in its own grid.
PlacedSolid asCloud(const Tool& tool) {
  const Eigen::Quaterniond turn = about(Vec3(3, 1, 2), 0.7);
  const PlacedSolid area{tool.solid, {turn, Vec3::Zero()}};
  const double s = 0.5;
  const auto box = boundsOf(area);
  const Eigen::Vector3i bricks =
      ((box.sizes() / s + Vec3::Constant(6)) / 8).array().ceil().cast<int>();
  const Vec3 low = box.min() - Vec3::Constant(3.3 * s);
  const auto coverage = [&](int x, int y, int z) {
    const double middle = depthOf(area, low + s * Vec3(x + .5, y + .5, z + .5));
    if (std::abs(middle) > s) return middle > 0 ? 255 : 0;
    int in = 0;
    for (int k = 0; k < 512; ++k) {
      const Vec3 part(k % 8 + .5, k / 8 % 8 + .5, k / 64 + .5);
      in += depthOf(area, low + s * (Vec3(x, y, z) + part / 8)) > 0;
    }
    return (in * 255 + 256) / 512;
  };
  return cloudSolid(test::smallCloud(s * kVoxel, bricks, coverage),
                    {turn.conjugate(), turn.conjugate() * (kVoxel * low)});
}

const TissueTable kTooth = {{"tooth", 1e4, 0, 1e9, 2000}};

// A tool over a block with the outward normal `normal`, at odd angles to both grids.
struct Pressed {
  Vec3 normal;
  Detection detection;
  Eigen::Quaterniond turn;
  Vec3 tip;  // from the tool's origin

  Pressed(const Tool& tool, const Vec3& n, const PlacedSolid& area) : normal(n) {
    detection.area = area;
    turn = shortestTurn(Vec3::UnitZ(), n) * about(Vec3::UnitZ(), 0.43) * tool.turn;
    tip = *farthestOf({scaled(tool.solid), {turn}}, -n);
  }
  // With its tip `depth` voxels deep, at one of several places of the grid.
  Pose at(double depth, int place) const {
    const Vec3 aside = place * Vec3(0.37, 0.32, 0);
    const Vec3 top = Vec3(32, 32, kTop) + aside - aside.dot(normal) * normal;
    return {turn, kVoxel * (top - depth * normal) - tip};
  }
};

TEST(EmbeddingAlong, SolidsInAFlatBlock) {
  for (const double tilt : {0.0, 0.37}) {
    const Vec3 n = up(tilt);
    const BaseVectorField field(block(n), kTooth, sphereWindow(kVoxel));
    for (const Tool& tool : tools()) {
      const Pressed pressed(tool, n, {scaled(tool.solid)});
      CollisionFinder finder;
      for (const double depth : {1.0, 2.0, 4.0})
        for (int place = 0; place < 4; ++place) {
          const Collision& c = finder.find(field, {}, pressed.detection, pressed.at(depth, place));
          const double force = 1e4 * depth * kVoxel;
          EXPECT_NEAR(c.depth / kVoxel, depth, 0.03) << tool.name << " tilt " << tilt;
          EXPECT_NEAR(kelvinVoigt(c, c.depth, 0), force, 0.03 * force) << tool.name;
        }
    }
  }
}

// A cloud's own voxels round its tips by up to a tenth of the workpiece's voxel; the tip of a cone,
// thinner than a voxel over a length of several, by a quarter.
TEST(EmbeddingAlong, CloudsInAFlatBlock) {
  for (const double tilt : {0.0, 0.37}) {
    const Vec3 n = up(tilt);
    const BaseVectorField field(block(n), kTooth, sphereWindow(kVoxel));
    for (const Tool& tool : tools()) {
      const bool cone = std::holds_alternative<Cone>(tool.solid);
      if (tool.name == "sharp cone" || std::holds_alternative<Ellipsoid>(tool.solid)) continue;
      const Pressed pressed(tool, n, asCloud(tool));
      CollisionFinder finder;
      for (const double depth : {1.0, 2.0, 4.0}) {
        if (cone && depth < 2) continue;
        for (int place = 0; place < 3; ++place) {
          const Collision& c = finder.find(field, {}, pressed.detection, pressed.at(depth, place));
          EXPECT_NEAR(c.depth / kVoxel, depth, cone ? 0.25 : 0.1) << tool.name << " tilt " << tilt;
          if (depth == 4 && !cone) {
            EXPECT_NEAR(kelvinVoigt(c, c.depth, 0), 1e4 * depth * kVoxel, 0.03e4 * depth * kVoxel)
                << tool.name;
          }
        }
      }
    }
  }
}

// The hand's spring is as stiff as the material: the tool goes half as deep as the hand.
TEST(EmbeddingAlong, HapticLoopHoldsEveryToolAtItsDepth) {
  const Vec3 n = up(0.37);
  for (const Tool& tool : tools()) {
    BaseVectorField field(block(n), {{"flesh", 1e3, 0.02, 1e9, 2000}}, sphereWindow(kVoxel));
    const Pressed pressed(tool, n, {scaled(tool.solid)});
    for (const double depth : {1.0, 4.0}) {
      HapticSettings settings;
      settings.tool = pressed.detection;
      HapticLoop loop(field, {}, settings);
      HapticOutput out;
      for (int k = 0; k <= 500; ++k)
        out = loop.tick({pressed.at(-2 + (2 + 2 * depth) * std::min(1.0, k / 300.0), 1)});
      EXPECT_EQ(out.end, EmbeddingEnd::Found) << tool.name;
      EXPECT_NEAR(out.depth / kVoxel, depth, 0.1) << tool.name;
      EXPECT_NEAR(out.onHand.force.dot(n), 1e3 * depth * kVoxel, 0.03e3 * depth * kVoxel)
          << tool.name;
      const double truth = n.dot(pressed.at(0, 1).position - out.tool.position);
      EXPECT_NEAR(truth / kVoxel, depth, 0.1) << tool.name << " is where it is said to be";
    }
  }
}

// In a hole that the tool has cut every line through it is as long as the tool has moved down. The
// windows blur the hole's surface: a ball's floor by a tenth of a voxel, the corners of a box's
// more.
TEST(EmbeddingAlong, InAHoleOfTheToolsOwnShape) {
  const std::vector<Tool> own = {{"ball", Sphere{6}, Eigen::Quaterniond::Identity()},
                                 {"box", Box{Vec3(5, 6, 7)}, about(Vec3::UnitZ(), 0.3)},
                                 {"round end", Capsule{4, 6}, Eigen::Quaterniond::Identity()},
                                 {"cylinder", Cylinder{5, 7}, Eigen::Quaterniond::Identity()}};
  for (const Tool& tool : own) {
    const PlacedSolid area{scaled(tool.solid)};
    const double half = boundsOf(area).max().z() / kVoxel;
    const Pose rest{tool.turn, kVoxel * Vec3(32.2, 31.7, kTop - 5 + half)};
    BaseVectorField field(block(Vec3::UnitZ()), kTooth, sphereWindow(kVoxel));
    field.cut(cutsOf(field, area, rest));
    Detection d;
    d.area = area;
    CollisionFinder finder;
    const double blur = std::holds_alternative<Sphere>(tool.solid) ? 0.2 : 0.35;
    for (const double depth : {1.0, 2.0}) {
      Pose pose = rest;
      pose.position.z() -= depth * kVoxel;
      EXPECT_NEAR(finder.find(field, {}, d, pose).depth / kVoxel, depth, blur) << tool.name;
    }
  }
}

// The unit alone: pieces of a plane, and a direction of one's own.
TEST(EmbeddingAlong, TakesPiecesFromAnywhere) {
  std::vector<PlanePiece> pieces;
  for (int k = 0; k < 400; ++k)
    pieces.push_back({0.1 * Vec3(k % 20 - 9.5, k / 20 - 9.5, 0), Vec3::UnitZ(), 1});
  const PlacedSolid box{Box{Vec3(0.5, 0.4, 0.3)}, {.position = Vec3(0, 0, 0.1)}};
  EmbeddingAlong embedding;
  EXPECT_NEAR(embedding.find({&box, Vec3::UnitZ(), 0.1, {}, 1}, pieces), 0.2, 1e-5);
  EXPECT_EQ(embedding.find({&box, Vec3::UnitZ(), 0.1, {}, 3}, pieces),
            embedding.find({&box, Vec3::UnitZ(), 0.1, {}, 1}, pieces));
  EXPECT_EQ(embedding.find({&box, Vec3::Zero(), 0.1, {}, 1}, pieces), 0) << "no direction";
  EXPECT_EQ(embedding.find({&box, Vec3::UnitZ(), 0.1, {}, 1}, {}), 0) << "no surface";
  const PlacedSolid above{Box{Vec3(0.5, 0.4, 0.3)}, {.position = Vec3(0, 0, 0.35)}};
  EXPECT_EQ(embedding.find({&above, Vec3::UnitZ(), 0.1, {}, 1}, pieces), 0) << "not touching";
}

}  // namespace
}  // namespace cloudcontact::embedding_along_test
