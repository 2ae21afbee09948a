// First guesses come from the points' extents along a few likely axes; least squares on the exact
// distance to the shape (solidAt) improves them.
#include "field/shape_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace cloudcontact {

namespace {

using Matrix = Eigen::Matrix3d;
using FitVector = Eigen::Matrix<double, 9, 1>;
using Square = Eigen::Matrix<double, 9, 9>;

constexpr int kFitRounds = 12;       // of least squares; it converges in three to six
constexpr double kStep = 1e-4;       // of the differences, of a unit of length
constexpr double kAlongAxis = 0.95;  // cosine: a normal is along an axis
constexpr double kAcross = 0.3;      // cosine: a normal is across an axis
constexpr std::size_t kTrials = 60;  // normals that are tried as a box's
constexpr std::size_t kFew = 200;    // points tell what a body is not

double square(const PlacedSolid& shape, const std::vector<ShapePoint>& surface) {
  double sum = 0, area = 0;
  for (const ShapePoint& s : surface) {
    const double depth = depthOf(shape, s.position);
    sum += s.area * depth * depth;
    area += s.area;
  }
  return sum / area;
}

// The lengths of a shape that may change, in order.
std::vector<double*> lengthsOf(Solid& solid) {
  if (auto* ball = std::get_if<Sphere>(&solid)) return {&ball->radius};
  if (auto* box = std::get_if<Box>(&solid))
    return {&box->halfExtents[0], &box->halfExtents[1], &box->halfExtents[2]};
  if (auto* cylinder = std::get_if<Cylinder>(&solid))
    return {&cylinder->radius, &cylinder->halfHeight};
  if (auto* capsule = std::get_if<Capsule>(&solid)) return {&capsule->radius, &capsule->halfHeight};
  auto& cone = std::get<Cone>(solid);
  return {&cone.radius, &cone.halfHeight};
}

// Rotations that change the shape: none of a ball, and not about an axis of revolution.
int turnsOf(const Solid& solid) {
  return std::holds_alternative<Sphere>(solid) ? 0 : std::holds_alternative<Box>(solid) ? 3 : 2;
}

// The shape with parameter `index` changed by `by`: three shifts, the turns, the lengths. A turn is
// scaled by `size` to move the surface by about `by`.
PlacedSolid changed(const PlacedSolid& shape, int index, double by, double size) {
  PlacedSolid next = shape;
  const int turns = turnsOf(shape.solid);
  if (index < 3) {
    next.place.position[index] += by;
  } else if (index < 3 + turns) {
    const Vec3 axis = Vec3::Unit(index - 3);
    next.place.orientation =
        (shape.place.orientation * Eigen::Quaterniond(Eigen::AngleAxisd(by / size, axis)))
            .normalized();
  } else {
    *lengthsOf(next.solid)[static_cast<std::size_t>(index - 3 - turns)] += by;
  }
  return next;
}

bool isPositive(PlacedSolid shape) {
  const auto lengths = lengthsOf(shape.solid);
  return std::all_of(lengths.begin(), lengths.end(),
                     [](const double* length) { return *length > 0; });
}

// One round of Gauss-Newton.
PlacedSolid improved(const PlacedSolid& shape, const std::vector<ShapePoint>& surface,
                     double size) {
  PlacedSolid copy = shape;
  const int count = 3 + turnsOf(shape.solid) + static_cast<int>(lengthsOf(copy.solid).size());
  std::vector<PlacedSolid> more, less;
  for (int i = 0; i < count; ++i) {
    more.push_back(changed(shape, i, kStep, size));
    less.push_back(changed(shape, i, -kStep, size));
  }
  Square normal = Square::Zero();
  FitVector right = FitVector::Zero();
  for (const ShapePoint& s : surface) {
    const double depth = depthOf(shape, s.position);
    FitVector slope = FitVector::Zero();
    for (int i = 0; i < count; ++i)
      slope[i] = (depthOf(more[i], s.position) - depthOf(less[i], s.position)) / (2 * kStep);
    normal += s.area * slope * slope.transpose();
    right -= s.area * depth * slope;
  }
  normal.diagonal().array() += 1e-9 * normal.trace() + 1e-30;
  const FitVector step = normal.ldlt().solve(right);
  PlacedSolid next = shape;
  for (int i = 0; i < count; ++i) next = changed(next, i, step[i], size);
  return next;
}

PlacedSolid refined(PlacedSolid shape, const std::vector<ShapePoint>& surface, double size) {
  double best = square(shape, surface);
  for (int round = 0; round < kFitRounds; ++round) {
    const PlacedSolid next = improved(shape, surface, size);
    if (!isPositive(next)) break;
    const double now = square(next, surface);
    if (!(now < best)) break;
    const bool done = now > 0.9999 * best;
    shape = next;
    best = now;
    if (done) break;
  }
  return shape;
}

struct Middle {
  Vec3 center = Vec3::Zero();
  Matrix spread = Matrix::Zero(), normals = Matrix::Zero();
  double size = 0;  // largest distance from the center
};

Middle middleOf(const std::vector<ShapePoint>& surface) {
  Middle m;
  double area = 0;
  for (const ShapePoint& s : surface) {
    m.center += s.area * s.position;
    area += s.area;
  }
  m.center /= area;
  for (const ShapePoint& s : surface) {
    const Vec3 from = s.position - m.center;
    m.spread += s.area * from * from.transpose();
    m.normals += s.area * s.normal * s.normal.transpose();
    m.size = std::max(m.size, from.norm());
  }
  return m;
}

// The direction with the largest area facing it, either way, among normals across `across`.
Vec3 facedMost(const std::vector<ShapePoint>& surface, const Vec3& across) {
  Vec3 best = Vec3::Zero();
  double most = 0;
  const std::size_t stride = std::max<std::size_t>(1, surface.size() / kTrials);
  for (std::size_t k = 0; k < surface.size(); k += stride) {
    const Vec3& trial = surface[k].normal;
    if (std::abs(trial.dot(across)) > kAcross) continue;
    double area = 0;
    Vec3 sum = Vec3::Zero();
    for (const ShapePoint& s : surface) {
      const double along = s.normal.dot(trial);
      if (std::abs(along) < kAlongAxis) continue;
      area += s.area;
      sum += s.area * (along < 0 ? -1 : 1) * s.normal;
    }
    if (area <= most) continue;
    most = area;
    best = sum.normalized();
  }
  return best;
}

std::optional<PlacedSolid> guessedBox(const std::vector<ShapePoint>& surface) {
  Matrix axes;
  axes.col(0) = facedMost(surface, Vec3::Zero());
  const Vec3 second = facedMost(surface, axes.col(0));
  axes.col(2) = axes.col(0).cross(second);
  if (axes.col(2).norm() < 0.5) return std::nullopt;
  axes.col(2).normalize();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const ShapePoint& s : surface) {
    const Vec3 local = axes.transpose() * s.position;
    low = low.cwiseMin(local);
    high = high.cwiseMax(local);
  }
  return PlacedSolid{Box{(high - low) / 2},
                     {Eigen::Quaterniond(axes), Vec3(axes * (low + high) / 2)}};
}

// A body of revolution seen along an axis through the middle.
struct Turned {
  Vec3 axis = Vec3::Zero();
  double low = 0, high = 0;  // along the axis, from the middle
  double radius = 0;         // mean of what faces outward across the axis
  double widest = 0;
  double tilt = 0;  // mean of the normals along the axis, by area across it: a cone's is not 0
};

Turned turnedAbout(const Vec3& axis, const Middle& m, const std::vector<ShapePoint>& surface) {
  Turned t;
  t.axis = axis;
  double area = 0;
  for (const ShapePoint& s : surface) {
    const Vec3 from = s.position - m.center;
    const double z = from.dot(axis), r = (from - z * axis).norm(), along = s.normal.dot(axis);
    t.low = std::min(t.low, z);
    t.high = std::max(t.high, z);
    t.widest = std::max(t.widest, r);
    if (std::abs(along) > kAlongAxis) continue;
    t.tilt += s.area * along;
    t.radius += (std::abs(along) < kAcross ? s.area : 1e-6 * s.area) * r;
    area += std::abs(along) < kAcross ? s.area : 1e-6 * s.area;
  }
  t.radius = area > 0 ? t.radius / area : t.widest;
  return t;
}

enum class Revolved { Cylinder, Capsule, Cone };

PlacedSolid guessOf(Revolved kind, const Turned& t, const Middle& m) {
  const double half = (t.high - t.low) / 2;
  PlacedSolid shape;
  Vec3 axis = t.axis;
  if (kind == Revolved::Cylinder) {
    shape.solid = Cylinder{t.radius, half};
  } else if (kind == Revolved::Capsule) {
    shape.solid = Capsule{t.radius, std::max(half - t.radius, 0.05 * half)};
  } else {
    if (t.tilt < 0) axis = -axis;  // the sides of a cone look to its tip
    shape.solid = Cone{t.widest, half, 0};
  }
  shape.place = {shortestTurn(Vec3::UnitZ(), axis), m.center + (t.low + t.high) / 2 * t.axis};
  return shape;
}

PlacedSolid revolved(Revolved kind, const Middle& m, const std::vector<ShapePoint>& surface) {
  PlacedSolid best;
  double least = std::numeric_limits<double>::infinity();
  for (const Matrix* tensor : {&m.spread, &m.normals}) {
    const Eigen::SelfAdjointEigenSolver<Matrix> solver(*tensor);
    for (int i = 0; i < 3; ++i) {
      const Turned turned = turnedAbout(solver.eigenvectors().col(i), m, surface);
      const PlacedSolid guess = guessOf(kind, turned, m);
      const double error = isPositive(guess) ? square(guess, surface) : least;
      if (!(error < least)) continue;
      least = error;
      best = guess;
    }
  }
  return best;
}

}  // namespace

std::vector<PlacedSolid> fittedShapes(const std::vector<ShapePoint>& surface, double most) {
  const Middle m = middleOf(surface);
  double radius = 0, area = 0;
  for (const ShapePoint& s : surface) {
    radius += s.area * (s.position - m.center).norm();
    area += s.area;
  }
  std::vector<PlacedSolid> guesses = {{Sphere{radius / area}, {Pose{}.orientation, m.center}}};
  if (const auto box = guessedBox(surface); box && isPositive(*box)) guesses.push_back(*box);
  for (const Revolved kind : {Revolved::Cylinder, Revolved::Capsule, Revolved::Cone})
    if (const PlacedSolid guess = revolved(kind, m, surface);
        !std::holds_alternative<Sphere>(guess.solid))
      guesses.push_back(guess);
  std::vector<ShapePoint> few;
  const std::size_t stride = std::max<std::size_t>(1, surface.size() / kFew);
  for (std::size_t k = 0; k < surface.size(); k += stride) few.push_back(surface[k]);
  std::vector<PlacedSolid> fitted;
  for (const PlacedSolid& guess : guesses) {
    const PlacedSolid shape = refined(guess, few, m.size);
    if (square(shape, few) <= most * most) fitted.push_back(refined(shape, surface, m.size));
  }
  return fitted;
}

}  // namespace cloudcontact
