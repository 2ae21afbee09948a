// Errors from sums over an answer's points.
#include "lab/answer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cloudcontact::program::lab {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

double angle(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// Angle from v to the nearest direction of the arc between `from` and `to`.
double angleToArc(const Vec3& v, const Vec3& from, const Vec3& to) {
  const Vec3 normal = from.cross(to).normalized();
  const bool between = normal.dot(from.cross(v)) > 0 && normal.dot(v.cross(to)) > 0;
  if (between) return std::asin(std::min(1.0, std::abs(normal.dot(v)) / v.norm()));
  return std::min(angle(v, from), angle(v, to));
}

double deepestOf(const std::vector<LabPoint>& points) {
  double deepest = 0;
  for (const LabPoint& p : points) deepest = std::max(deepest, p.depth);
  return deepest;
}

}  // namespace

Vec3 forceOf(const std::vector<LabPoint>& points) {
  Vec3 force = Vec3::Zero();
  for (const LabPoint& p : points) force += p.share * p.depth * p.normal;
  return force;
}

AnswerError errorOf(const std::vector<LabPoint>& points, const Truth& truth, double size) {
  const Vec3 force = forceOf(points), center = truth.center.value_or(Vec3::Zero());
  Vec3 torque = Vec3::Zero();  // about the true center, or the origin
  for (const LabPoint& p : points)
    torque += (p.position - center).cross(p.share * p.depth * p.normal);
  AnswerError error;
  const double strength = force.norm();
  if (!(strength > 0)) return error;
  error.normalDeg = (truth.squareLaw ? angleToArc(force, truth.direction, *truth.squareLaw)
                                     : angle(force, truth.direction)) /
                    kDegree;
  if (const auto deepest = truth.deepest ? truth.deepest : truth.depth) {
    error.depth = std::abs(deepestOf(points) - *deepest);
    error.depthTimes = deepestOf(points) / *deepest;
    error.wrongDepth = error.depth > kWrongDepth * size;
  }
  if (truth.depth) error.force = std::abs(strength / *truth.depth - 1);
  if (truth.center) {
    const Vec3 across = torque - torque.dot(force) / strength * force / strength;
    error.center = across.norm() / strength;
    error.torque = torque.norm() / (strength * size);
  }
  if (truth.torquePerForce)
    error.torque = std::abs(torque.z() / force.z() / *truth.torquePerForce - 1);
  return error;
}

SwapError swapError(const std::vector<LabPoint>& answer, const LabPair& swapped, const Pose& pose) {
  const Vec3 force = forceOf(answer);
  const Vec3 back = -(pose.orientation * forceOf(swapped.find(pose.inverse())));
  if (!(force.norm() > 0)) return {};
  return {angle(force, back) / kDegree, std::abs(back.norm() / force.norm() - 1)};
}

double loopWork(const LabPair& pair, const Pose& pose, const Vec3& direction, double radius,
                int steps) {
  const Vec3 along = direction.normalized(), aside = along.unitOrthogonal();
  // The trapezoidal rule, which converges exponentially for periodic functions.
  double net = 0, all = 0;
  for (int k = 0; k < steps; ++k) {
    const double turn = 2 * std::numbers::pi * k / steps;
    Pose now = pose;
    now.position += radius * (std::cos(turn) * aside + std::sin(turn) * along);
    const Vec3 way = std::cos(turn) * along - std::sin(turn) * aside;
    const Vec3 force = forceOf(pair.find(now));
    if (!(force.norm() > 0)) return kUnknown;
    net += force.dot(way);
    all += std::abs(force.dot(way));
  }
  return all > 0 ? std::abs(net) / all : kUnknown;
}

}  // namespace cloudcontact::program::lab
