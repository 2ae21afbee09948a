#include "contact/pressed_parts.h"

#include <cloudcontact/voxels/digitize.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "contact/contact_cases.h"
#include "field/mesh_field.h"
#include "mesh/thread_meshes.h"

namespace cloudcontact::testing {

namespace {

using Vec2 = Eigen::Vector2d;
using Quaternion = Eigen::Quaterniond;
using Outside = std::function<double(const Vec3&)>;
using PartPointer = std::shared_ptr<const Part>;

constexpr double kPi = std::numbers::pi;
constexpr double kVoxel = 1e-3, kThreadVoxel = 0.25e-3;  // [m]
const std::vector<double> kDepths{0.1, 0.3, 1.0};        // [voxels]

PartPointer partOf(Mesh mesh, Outside outside, double voxel = kVoxel) {
  static Random random(7);
  const Pose grid{random.rotation(), voxel * random.inCube()};
  auto field = fieldOf(transformed(mesh, grid), voxel);
  return std::make_shared<Part>(
      Part{voxel, std::move(mesh), std::move(outside), std::move(field), grid});
}

// The distance of a place to a closed polygon, negative inside.
double polygonDistance(const std::vector<Vec2>& polygon, const Vec2& p) {
  double least = 1e30;
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()], way = b - a;
    const double t = std::clamp((p - a).dot(way) / way.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (p - a - t * way).norm());
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * way.x())
      inside = !inside;
  }
  return inside ? -least : least;
}

// The solid that a profile (radius, z) sweeps about z; `ring`: a closed profile, else it begins and
// ends on the axis.
PartPointer turnedPart(std::vector<Vec2> profile, bool ring) {
  for (Vec2& p : profile) p *= kVoxel;
  std::vector<Vec2> fine, closed = profile;
  for (std::size_t i = 0; i + (ring ? 0 : 1) < profile.size(); ++i) {
    const Vec2 &a = profile[i], way = profile[(i + 1) % profile.size()] - a;
    const int pieces = std::max(1, int(std::ceil(way.norm() / (1.5 * kVoxel))));
    for (int k = 0; k < pieces; ++k) fine.push_back(a + way * k / pieces);
  }
  if (!ring) {
    fine.push_back(profile.back());
    for (auto p = profile.rbegin(); p != profile.rend(); ++p)
      if (p->x() > 0) closed.emplace_back(-p->x(), p->y());
  }
  const int along = int(fine.size());
  Mesh mesh = revolvedMesh(300, along, ring, [&](double angle, double s) {
    const Vec2& p = fine[std::size_t(std::lround(s * (ring ? along : along - 1)))];
    return Vec3(p.x() * std::cos(angle), p.x() * std::sin(angle), p.y());
  });
  return partOf(std::move(mesh), [closed](const Vec3& x) {
    return polygonDistance(closed, {std::hypot(x.x(), x.y()), x.z()});
  });
}

PartPointer torusPart(double ring, double tube) {
  std::vector<Vec2> circle;
  for (int i = 0; i < 96; ++i)
    circle.emplace_back(ring + tube * std::cos(kPi * i / 48), tube * std::sin(kPi * i / 48));
  return turnedPart(circle, true);
}

PartPointer ballPart(double radius) {
  std::vector<Vec2> half;
  for (int i = 0; i <= 64; ++i)
    half.emplace_back(i % 64 ? radius * std::sin(kPi * i / 64) : 0.0,
                      -radius * std::cos(kPi * i / 64));
  return turnedPart(half, false);
}

PartPointer cylinderPart(double radius, double length) {
  const double z = length / 2;
  return turnedPart({{0, -z}, {radius, -z}, {radius, z}, {0, z}}, false);
}

PartPointer pipePart(double inner, double outer, double length) {
  const double z = length / 2;
  return turnedPart({{outer, -z}, {outer, z}, {inner, z}, {inner, -z}}, true);
}

// A cylinder with half a ball cut out of its top, which is at z = 0.
PartPointer bowlPart(double radius, double outer) {
  std::vector<Vec2> profile{{0, -outer}, {outer, -outer}, {outer, 0}};
  for (int i = 0; i <= 48; ++i)
    profile.emplace_back(i < 48 ? radius * std::cos(kPi * i / 96) : 0.0,
                         -radius * std::sin(kPi * i / 96));
  return turnedPart(profile, false);
}

PartPointer boxPart(const Vec3& edges) {
  const Vec3 half = edges * kVoxel / 2;
  return partOf(boxMesh(2 * half), [half](const Vec3& x) {
    const Vec3 beyond = x.cwiseAbs() - half;
    return beyond.cwiseMax(0.0).norm() + std::min(0.0, beyond.maxCoeff());
  });
}

double triangleDistance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a);
  const Vec3* const corner[3] = {&a, &b, &c};
  bool over = true;
  double least = 1e30;
  for (int i = 0; i < 3; ++i) {
    const Vec3 &from = *corner[i], way = *corner[(i + 1) % 3] - from;
    over = over && normal.cross(way).dot(p - from) >= 0;
    const double t = std::clamp((p - from).dot(way) / way.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (p - from - t * way).norm());
  }
  return over ? std::abs(normal.normalized().dot(p - a)) : least;
}

// The distance to a mesh up to `most` [m], with the sign of a formula.
Outside meshDistance(const Mesh& mesh, std::function<bool(const Vec3&)> inside, double most) {
  return [mesh, inside = std::move(inside), most](const Vec3& p) {
    double least = most;
    for (const Eigen::Vector3i& t : mesh.triangles) {
      const Vec3 &a = mesh.vertices[std::size_t(t[0])], &b = mesh.vertices[std::size_t(t[1])],
                 &c = mesh.vertices[std::size_t(t[2])];
      if (((a.cwiseMin(b).cwiseMin(c) - p).array() > least).any() ||
          ((p - a.cwiseMax(b).cwiseMax(c)).array() > least).any())
        continue;
      least = std::min(least, triangleDistance(p, a, b, c));
    }
    return inside(p) ? -least : least;
  };
}

Pose at(double x, double y, double z, const Quaternion& turn = Quaternion::Identity()) {
  return {turn, Vec3(x, y, z) * kVoxel};
}

Quaternion about(const Vec3& axis, double angle) {
  return Quaternion(Eigen::AngleAxisd(angle, axis.normalized()));
}

// Collects the pairs of a kind.
struct Pairs {
  std::vector<PressedPair> all;

  void add(const std::string& name, const PartPointer& a, const PartPointer& b, const Pose& poseB) {
    add(name, a, b, poseB, overlapOf(*a, {}, *b, poseB));
  }
  void add(const std::string& name, const PartPointer& a, const PartPointer& b, const Pose& poseB,
           double overlap) {
    const Pose world{Quaternion(0.83, -0.31, 0.42, 0.19).normalized(), {0.3, -0.2, 0.1}};
    all.push_back({name, a, b, world, world * poseB, overlap});
  }
};

const Vec3 kX = Vec3::UnitX(), kY = Vec3::UnitY(), kZ = Vec3::UnitZ();
const Vec3 kOblique(1, 0.3, 0);

void addTori(Pairs& pairs) {
  const PartPointer a = torusPart(30, 10), b = torusPart(30, 10), small = torusPart(20, 8);
  for (const double d : kDepths) {
    pairs.add("coaxial", a, b, at(0, 0, 20 - d));
    pairs.add("seated", a, small, at(0, 0, std::sqrt((18 - d) * (18 - d) - 100)));
    for (const double tilt : {0.003, 0.01, 0.02, 0.04})
      pairs.add("tilted " + std::to_string(tilt), a, b,
                at(0, 0, 20 - d + 30 * tilt, about(kOblique, tilt)));
    for (const double aside : {2.0, 10.0, 30.0, 45.0})
      pairs.add("aside " + std::to_string(aside), a, b, at(aside, 0, 20 - d));
    pairs.add("crossed", a, b, at(30, 0, 50 - d, about(kX, kPi / 2)));
    pairs.add("linked", a, b, at(40 + d, 0, 0, about(kX, kPi / 2)));
  }
}

void addRings(Pairs& pairs) {
  const PartPointer plate = boxPart({90, 88, 12}), torus = torusPart(30, 8),
                    pipe = pipePart(24, 30, 20), ball = ballPart(25), small = torusPart(6, 3);
  for (const double d : kDepths) {
    for (const double tilt : {0.0, 0.005, 0.02, 0.1})
      pairs.add("torus tilted " + std::to_string(tilt), plate, torus,
                at(0, 0, 14 - d + 30 * std::sin(tilt), about(kOblique, tilt)));
    for (const double tilt : {0.0, 0.005, 0.02})
      pairs.add("pipe tilted " + std::to_string(tilt), plate, pipe,
                at(0, 0, 16 - d + 30 * std::sin(tilt), about(kOblique, tilt)));
    pairs.add("torus over an edge", plate, torus, at(45, 0, 14 - d));
    pairs.add("torus over a corner", plate, torus, at(45, 44, 14 - d));
    pairs.add("small torus", plate, small, at(0, 0, 9 - d));
    pairs.add("ball in torus", torus, ball, at(0, 0, std::sqrt((33 - d) * (33 - d) - 900)));
  }
}

void addPegs(Pairs& pairs) {
  const PartPointer peg = cylinderPart(16, 50), hole = pipePart(16.4, 40, 30),
                    wide = cylinderPart(30, 70);
  for (const double d : kDepths) {
    pairs.add("offset", hole, peg, at(0.4 + d, 0, 5));
    for (const double z : {3.0, 12.0}) {
      // The tilt at which the peg is in the hole's wall by d.
      double least = 0, most = 0.3;
      for (int i = 0; i < 12; ++i) {
        const double tilt = (least + most) / 2;
        const Pose pose = at(0, 0, z, about({0.2, 1, 0}, tilt));
        (overlapOf(*hole, {}, *peg, pose) < d * kVoxel ? least : most) = tilt;
      }
      pairs.add("tilted at " + std::to_string(z), hole, peg, at(0, 0, z, about({0.2, 1, 0}, most)));
    }
    pairs.add("on the rim", hole, wide, at(3, 1, 50 - d + 30 * std::sin(0.01), about(kY, 0.01)));
    pairs.add("caught in the rim", hole, peg,
              at(6, 0, 10 + 25 * std::cos(0.3) - d, about(kY, 0.3)));
  }
}

void addCorners(Pairs& pairs) {
  const PartPointer a = boxPart({40, 36, 12}), b = boxPart({24, 30, 14});
  const Vec3 corner(12, 15, 7);
  for (const double d : kDepths)
    pairs.add("on a corner", a, b, at(0, 0, 6 + corner.norm() - d, shortestTurn(corner, -kZ)));
}

void addBoxes(Pairs& pairs) {
  const PartPointer a = boxPart({40, 36, 12}), b = boxPart({24, 30, 14});
  for (const double d : kDepths) {
    pairs.add("flush", a, b, at(0, 0, 13 - d, about(kZ, 0.3)));
    pairs.add("over an edge", a, b, at(15, 3, 13 - d, about(kZ, 0.3)));
    for (const double tilt : {0.01, 0.04, 0.3})
      pairs.add("tilted " + std::to_string(tilt), a, b,
                at(0, 0, 6 + 7 * std::cos(tilt) + 12 * std::sin(tilt) - d, about(kY, tilt)));
  }
}

void addRound(Pairs& pairs) {
  const PartPointer ball = ballPart(18), bowl = bowlPart(20, 30), snug = bowlPart(18.6, 30),
                    cylinder = cylinderPart(12, 40), plate = boxPart({60, 50, 12});
  for (const double d : kDepths) {
    pairs.add("ball on plate", plate, ball, at(3, 2, 24 - d));
    pairs.add("ball in bowl", bowl, ball, at(0, 0, -2 - d));
    pairs.add("ball in snug bowl", snug, ball, at(0, 0, -0.6 - d));
    pairs.add("ball beside bowl's bottom", bowl, ball,
              at((2 + d) * std::sin(0.5), 0, -(2 + d) * std::cos(0.5)));
    pairs.add("cylinder", plate, cylinder, at(3, 2, 18 - d, about(kY, kPi / 2)));
    pairs.add(
        "cylinder tilted", plate, cylinder,
        at(3, 2, 6 + 12 * std::cos(0.01) + 20 * std::sin(0.01) - d, about(kY, kPi / 2 + 0.01)));
    pairs.add("ball on ball", ball, ball, at(0, 0, 36 - d));
  }
}

void addThreads(Pairs& pairs) {
  const Thread thread;
  const double play = 0.1e-3, height = 13e-3, length = 24e-3, outer = 12e-3;
  const auto radiusAt = [thread](const Vec3& x) {
    return thread.at(std::atan2(x.y(), x.x()), x.z());
  };
  const auto radius = [](const Vec3& x) { return std::hypot(x.x(), x.y()); };
  const Mesh rod = threadedRod(thread, length, 180, 600),
             ring = threadedRing(thread, height, outer, play, 180, 330);
  const PartPointer bolt = partOf(
      rod,
      meshDistance(
          rod,
          [=](const Vec3& x) { return std::abs(x.z()) < length / 2 && radius(x) < radiusAt(x); },
          4e-3),
      kThreadVoxel);
  const PartPointer nut = partOf(ring,
                                 meshDistance(
                                     ring,
                                     [=](const Vec3& x) {
                                       return std::abs(x.z()) < height / 2 && radius(x) < outer &&
                                              radius(x) > radiusAt(x) + play;
                                     },
                                     4e-3),
                                 kThreadVoxel);
  const double slope = 2 * thread.depth / thread.pitch;  // of the radius along z
  const double steep = std::sqrt(1 + slope * slope);
  for (const double d : kDepths)
    for (const double tilt : {0.0, 0.002})
      for (const double turn : {0.0, 1.7}) {
        // A tilt presses the flanks at the nut's upper rim most, across them.
        const double axial = (play + d * kThreadVoxel * steep) / slope;
        const double more = tilt * (slope * height / 2 + thread.radius) / steep;
        pairs.add("nut tilted " + std::to_string(tilt) + " turned " + std::to_string(turn), bolt,
                  nut,
                  {about(kX, tilt) * about(kZ, turn),
                   Vec3(0, 0, axial + turn / (2 * kPi) * thread.pitch)},
                  d * kThreadVoxel + more);
      }
}

}  // namespace

ContactBody Part::at(const Pose& pose) const {
  ContactBody body;
  body.field = field.get();
  body.pose = pose * grid.inverse();
  return body;
}

double overlapOf(const Part& a, const Pose& poseA, const Part& b, const Pose& poseB) {
  double deepest = 0;
  const auto look = [&](const Part& from, const Pose& poseFrom, const Part& in,
                        const Pose& poseIn) {
    const Pose way = poseIn.inverse() * poseFrom;
    for (const Eigen::Vector3i& t : from.mesh.triangles) {
      const Vec3 p = way.toWorld(from.mesh.vertices[std::size_t(t[0])]),
                 q = way.toWorld(from.mesh.vertices[std::size_t(t[1])]) - p,
                 r = way.toWorld(from.mesh.vertices[std::size_t(t[2])]) - p;
      const double longest = std::max({q.norm(), r.norm(), (q - r).norm()});
      const int pieces = std::clamp(int(longest / (0.7 * from.voxel)), 1, 200);
      for (int i = 0; i <= pieces; ++i)
        for (int j = 0; i + j <= pieces; ++j)
          deepest = std::max(deepest, -in.outside(p + q * i / pieces + r * j / pieces));
    }
  };
  look(a, poseA, b, poseB);
  look(b, poseB, a, poseA);
  return deepest;
}

std::vector<PressedPair> pressedPairs(const std::string& kind) {
  Pairs pairs;
  if (kind == "tori") addTori(pairs);
  if (kind == "rings") addRings(pairs);
  if (kind == "pegs") addPegs(pairs);
  if (kind == "boxes") addBoxes(pairs);
  if (kind == "corners") addCorners(pairs);
  if (kind == "round") addRound(pairs);
  if (kind == "threads") addThreads(pairs);
  return std::move(pairs.all);
}

}  // namespace cloudcontact::testing
