// For a unit vector n, the depth along n is how far A reaches along n beyond where B begins. Its
// minimum over all n is the true depth, so any n gives an upper bound, and of several the least is
// right.
#include "contact/press_direction.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

using Matrix = Eigen::Matrix3d;

// Where a face is nearly as short a way as an edge or a curved surface, the face it is. Without it
// boxes at rest would change between a face and edges nearly parallel to it.
constexpr double kFaceFirst = 0.02;      // of the depth
constexpr double kFaceFirstSize = 1e-7;  // of the bodies' distance
constexpr double kParallel = 1e-6;       // square of the sine between edges that make no direction
constexpr double kPrecision = 1e-10;     // of the bodies' distance
constexpr double kSkin = 0.01;           // of the bodies' distance, the first guess
constexpr int kDirectionRounds = 4;      // skins that are tried
constexpr int kCloser = 6;               // skins that are tried from there
constexpr double kLess = 0.7;            // of a skin
constexpr double kCloseEnough = 0.9;     // of a skin under which the cores are apart

PressDirection against(const PlacedConvex& half, const PlacedConvex& body) {
  const auto& plane = std::get<HalfSpace>(*half.solid);
  const Vec3 n = half.turn * plane.normal;
  return {n, plane.offset + n.dot(half.at) - n.dot(body.support(-n))};
}

PressDirection ofBall(const PlacedConvex& body, const PlacedConvex& ball) {
  const SolidPoint p = solidAt(*body.solid, body.turn.transpose() * (ball.at - body.at));
  return {body.turn * p.normal, p.depth + std::get<Sphere>(*ball.solid).radius};
}

PressDirection turnedRound(const PressDirection& way) {
  return {-way.normal, way.depth};
}

// The best of a number of directions, of faces and others.
class Shortest {
 public:
  explicit Shortest(double size) : slack_(kFaceFirstSize * size) {}
  void offer(const Vec3& normal, double depth) { put(face_, normal, depth); }
  void offerEdge(const Vec3& normal, double depth) { put(edge_, normal, depth); }
  const std::optional<PressDirection>& face() const { return face_; }
  bool isFace() const {
    return face_ &&
           !(edge_ && edge_->depth < face_->depth - kFaceFirst * std::abs(face_->depth) - slack_);
  }
  const PressDirection& best() const { return isFace() ? *face_ : *edge_; }

 private:
  static void put(std::optional<PressDirection>& best, const Vec3& normal, double depth) {
    if (!best || depth < best->depth) best = PressDirection{normal, depth};
  }
  double slack_;
  std::optional<PressDirection> face_, edge_;
};

// All in A's axes: column j of `turn` is B's axis j. An edge's direction is that of A's axis i
// across B's axis j, whose length is the sine between them.
PressDirection ofBoxes(const PlacedConvex& a, const PlacedConvex& b) {
  const Vec3 &halfA = std::get<Box>(*a.solid).halfExtents,
             &halfB = std::get<Box>(*b.solid).halfExtents;
  const Vec3 apart = b.at - a.at, far = a.turn.transpose() * apart;
  const Matrix turn = a.turn.transpose() * b.turn, size = turn.cwiseAbs();
  const Vec3 onA = halfA + size * halfB - far.cwiseAbs(), farB = turn.transpose() * far;
  const Vec3 onB = halfB + size.transpose() * halfA - farB.cwiseAbs();
  int i, j;
  const bool first = onA.minCoeff(&i) <= onB.minCoeff(&j);
  const auto toB = [](const Vec3& axis, double way) { return way < 0 ? Vec3(-axis) : axis; };
  const PressDirection face = first ? PressDirection{toB(a.turn.col(i), far[i]), onA[i]}
                                    : PressDirection{toB(b.turn.col(j), farB[j]), onB[j]};
  double least =
      face.depth - kFaceFirst * std::abs(face.depth) - kFaceFirstSize * far.cwiseAbs().maxCoeff();
  int edgeA = -1, edgeB = -1;
  for (i = 0; i < 3; ++i)
    for (j = 0; j < 3; ++j) {
      const double sine = 1 - turn(i, j) * turn(i, j);
      if (sine < kParallel) continue;
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const double reach = halfA[i1] * size(i2, j) + halfA[i2] * size(i1, j) +
                           halfB[j1] * size(i, j2) + halfB[j2] * size(i, j1);
      const double way = std::abs(far[i2] * turn(i1, j) - far[i1] * turn(i2, j));
      const double depth = (reach - way) / std::sqrt(sine);
      if (depth >= least) continue;
      least = depth;
      edgeA = i, edgeB = j;
    }
  if (edgeA < 0) return face;
  const Vec3 axis = a.turn.col(edgeA).cross(b.turn.col(edgeB)).normalized();
  return {toB(axis, axis.dot(apart)), least};
}

double depthAlong(const PlacedConvex& a, const PlacedConvex& b, const Vec3& n) {
  return a.reach(n) + b.reach(-n) - n.dot(b.at - a.at);
}

bool isRound(const Solid& solid) {
  return !std::holds_alternative<Box>(solid) && !std::holds_alternative<Hull>(solid);
}

// Symmetric about its center.
bool isEven(const Solid& solid) {
  return !std::holds_alternative<Cone>(solid) && !std::holds_alternative<Hull>(solid);
}

// The directions of a body's faces, and outward from its axis to the other body.
void offerFaces(const PlacedConvex& body, const PlacedConvex& a, const PlacedConvex& b,
                Shortest& shortest) {
  if (const auto* hull = std::get_if<Hull>(body.solid)) {
    const double toB = &body == &a ? 1 : -1;
    for (const HalfSpace& plane : hull->planes) {
      const Vec3 n = body.turn * (toB * plane.normal);
      shortest.offer(n, depthAlong(a, b, n));
    }
    return;
  }
  // Of bodies that are symmetric about their centers, the way to the other's center is the shorter.
  const bool even = isEven(*a.solid) && isEven(*b.solid);
  const auto both = [&](const Vec3& axis) {
    const double far = axis.dot(b.at - a.at);
    if (!even || far >= 0) shortest.offer(axis, depthAlong(a, b, axis));
    if (!even || far < 0) shortest.offer(-axis, depthAlong(a, b, -axis));
  };
  if (std::holds_alternative<Box>(*body.solid)) {
    for (int i = 0; i < 3; ++i) both(body.turn.col(i));
    return;
  }
  if (!std::holds_alternative<Capsule>(*body.solid)) both(body.turn.col(2));
}

// The other body's center as seen across a body's axis, and across both axes.
void offerSides(const PlacedConvex& a, const PlacedConvex& b, Shortest& shortest) {
  const Vec3 apart = b.at - a.at;
  const auto try1 = [&](const Vec3& way) {
    if (way.squaredNorm() < kParallel * apart.squaredNorm()) return;
    const Vec3 n = way.normalized();
    shortest.offerEdge(n, depthAlong(a, b, n));
  };
  for (const PlacedConvex* body : {&a, &b})
    if (isRound(*body->solid) && !std::holds_alternative<Cone>(*body->solid))
      try1(apart - apart.dot(body->turn.col(2)) * body->turn.col(2));
  if (!isRound(*a.solid) || !isRound(*b.solid)) return;
  const Vec3 cross = a.turn.col(2).cross(b.turn.col(2));
  if (cross.squaredNorm() < kParallel) return;
  const Vec3 n = (cross.dot(apart) < 0 ? -1 : 1) * cross.normalized();
  shortest.offerEdge(n, depthAlong(a, b, n));
}

PlacedConvex placedCore(const PlacedCore& core, const PlacedConvex& body) {
  return {core.solid ? &*core.solid : body.solid, body.turn,
          body.at - core.sinks * body.turn.col(2), core.scale};
}

bool isHull(const Solid& solid) {
  return std::holds_alternative<Hull>(solid);
}
// Its core is its segment, whatever the skin.
bool isExact(const Solid& solid) {
  return std::holds_alternative<Capsule>(solid);
}

// A's share of both skins, of 2. A body beside a capsule needs none, and the way is exact. A hull's
// core is scaled, not thinner by the same everywhere, so the other body gives all.
double skinShare(const Solid& a, const Solid& b) {
  if (isExact(a) != isExact(b)) return isExact(a) ? 2 : 0;
  if (isHull(a) != isHull(b)) return isHull(b) ? 2 : 0;
  return 1;
}

// The way between the cores under skins of this thickness; empty if they overlap.
std::optional<Vec3> wayBetweenCores(const PlacedConvex& a, const PlacedConvex& b, double skin,
                                    double size) {
  const double shareA = skinShare(*a.solid, *b.solid);
  const PlacedCore coreA = coreOf(*a.solid, shareA * skin);
  const PlacedCore coreB = coreOf(*b.solid, (2 - shareA) * skin);
  return wayBetween(placedCore(coreA, a), placedCore(coreB, b), kPrecision * size);
}

// Skins as thick as the bodies are deep in each other turn the way the least.
std::optional<PressDirection> ofOthers(const PlacedConvex& a, const PlacedConvex& b) {
  const double size = (b.at - a.at).norm();
  Shortest shortest(size);
  offerFaces(a, a, b, shortest);
  offerFaces(b, a, b, shortest);
  offerSides(a, b, shortest);
  const bool exact = isExact(*a.solid) || isExact(*b.solid);
  double skin = kSkin * size;
  std::optional<Vec3> way;
  for (int round = 0; round < kDirectionRounds && !(way = wayBetweenCores(a, b, skin, size));
       ++round)
    skin *= 8;
  if (!way) return std::nullopt;
  double apart = skin, within = 0;  // skins between which the cores come to touch
  for (int round = 0; round < kCloser; ++round) {
    if (way) {
      const double depth = depthAlong(a, b, *way);
      shortest.offerEdge(*way, depth);
      if (exact || !(depth > 0)) break;
      apart = skin;
      skin = std::min(0.6 * depth, kLess * skin);
    } else {
      within = skin;
    }
    if (skin <= within) skin = (within + apart) / 2;
    if (skin > kCloseEnough * apart) break;
    way = wayBetweenCores(a, b, skin, size);
  }
  return shortest.best();
}

}  // namespace

std::optional<PressDirection> faceDirection(const PlacedConvex& a, const PlacedConvex& b) {
  Shortest shortest((b.at - a.at).norm());
  offerFaces(a, a, b, shortest);
  offerFaces(b, a, b, shortest);
  if (!shortest.face()) return std::nullopt;
  offerSides(a, b, shortest);
  return shortest.isFace() ? shortest.face() : std::nullopt;
}

std::optional<PressDirection> pressDirection(const PlacedConvex& a, const PlacedConvex& b) {
  if (std::holds_alternative<HalfSpace>(*a.solid)) return against(a, b);
  if (std::holds_alternative<HalfSpace>(*b.solid)) return turnedRound(against(b, a));
  if (std::holds_alternative<Sphere>(*b.solid)) return ofBall(a, b);
  if (std::holds_alternative<Sphere>(*a.solid)) return turnedRound(ofBall(b, a));
  if (std::holds_alternative<Box>(*a.solid) && std::holds_alternative<Box>(*b.solid))
    return ofBoxes(a, b);
  return ofOthers(a, b);
}

bool isClosedForm(const Solid& a, const Solid& b) {
  const auto simple = [](const Solid& s) {
    return std::holds_alternative<HalfSpace>(s) || std::holds_alternative<Sphere>(s);
  };
  return simple(a) || simple(b) ||
         (std::holds_alternative<Box>(a) && std::holds_alternative<Box>(b));
}

}  // namespace cloudcontact
