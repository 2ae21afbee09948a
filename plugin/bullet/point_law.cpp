// The pair's tangent, what turns it, and a point's share of both.
#include "bullet/point_law.h"

#include <algorithm>

#include "bullet/point_friction.h"

namespace cloudcontact {

namespace {

// The depth at which a point's share of k gives its force. The depth that it states is an overlap.
double pressedDepth(const ContactPoint& p) {
  return p.depth > 0 && p.slope > 0 ? p.stiffness / p.slope * p.depth : p.depth;
}

// Whether a point is of a touch: none of a near miss beside one.
bool touches(const ContactPoint& p, const ContactResult& contact) {
  return !contact.patches[static_cast<std::size_t>(p.patch)].beside;
}

// The spring's tangent at the mean depth of the pair's points. One tangent for all of them: a deep
// point's own would be steeper and would magnify the noise in the pressure's slope. The shares of
// points that are not beside a touch add up to `whole`, whatever became of their depths.
SpringTangent tangentOf(const AutomaticSpring& spring, const PairSides& sides,
                        const ContactResult& contact, double whole, double step) {
  double depth = 0, closing = 0;
  for (const ContactPoint& p : contact.points) {
    if (!touches(p, contact)) continue;
    const Vec3 meeting = sides.motionA.at(p.position) - sides.motionB.at(p.position);
    depth += p.slope * pressedDepth(p);
    closing += p.slope * meeting.dot(p.normal);
  }
  SpringTangent tangent = spring.tangent(depth / whole, closing / whole, step);
  tangent.slope /= whole;
  tangent.damping /= whole;
  return tangent;
}

// How far apart the points are, 0..1. What a ball stands on alone turns by no spring: its points
// are at one place. Those of a face are spread as much as its area is.
double spreadOf(const ContactResult& contact, double whole) {
  constexpr double kSquare = 1.0 / 6;  // mean square of places in a square from its middle, by area
  double area = 0, square = 0;
  Vec3 first = Vec3::Zero();
  for (const ContactPoint& p : contact.points) {
    if (!touches(p, contact)) continue;
    const Patch& patch = contact.patches[static_cast<std::size_t>(p.patch)];
    const Vec3 at = p.position - contact.points.front().position;
    area += patch.area / patch.points;
    first += p.slope / whole * at;
    square += p.slope / whole * at.squaredNorm();
  }
  return area > 0 ? std::clamp((square - first.squaredNorm()) / (kSquare * area), 0.0, 1.0) : 0;
}

}  // namespace

PointLaw::PointLaw(const ContactResult& contact, const PairSides& sides,
                   const WriteSettings& settings)
    : sides_(sides), settings_(settings) {
  for (const ContactPoint& p : contact.points)
    if (touches(p, contact)) slope_ += p.slope;
  if (!(slope_ > 0)) return;
  if (settings.automatic)
    tangent_ = tangentOf(*settings.automatic, sides, contact, slope_, settings.step);
  turning_ = 0.5 * contact.pointed * spreadOf(contact, slope_);
}

KelvinVoigt PointLaw::shareOf(const ContactPoint& source, double pressed) const {
  if (!tangent_ && !settings_.shared) return {source.slope, source.damping};
  const KelvinVoigt part = tangent_ ? tangent_->row(pressed, settings_.step) : *settings_.shared;
  return {part.stiffness * source.slope, part.damping * source.slope};
}

// What a point's row grows more than by its `stiffness`, over it.
//
// With mass m, a step of h is unstable from (b - 1) h^2 k / m = 4 on; a spring far below that needs
// no more. And a point that slides on within the step is pressed in another place at its end: a nut
// that runs down its bolt would be held back there, as normals lean by up to 3 deg.
double PointLaw::growthAt(const ContactPoint& source, double stiffness) const {
  constexpr double kStable = 4, kStays = 0.1;  // kStays: of its depth
  if (!(turning_ > 0) || !(source.depth > 0) || !(stiffness > 0)) return 0;
  const double step = settings_.step, pair = step * step * stiffness * slope_ / source.slope;
  const double slid = step * slipOf(source, sides_.motionA, sides_.motionB).norm() / source.depth;
  return turning_ * pair / (pair + kStable * sides_.mass) * std::max(0.0, 1 - slid / kStays);
}

// Bullet's row is k (depth + step v) + c v. A point's force is that of its share of k at the depth
// at which it is pressed; so at the depth that it states, its k is another, and c takes the
// difference in growth.
void PointLaw::write(const ContactPoint& source, btManifoldPoint& point) const {
  const double pressed = pressedDepth(source), step = settings_.step;
  KelvinVoigt law = shareOf(source, pressed);
  law.damping += step * growthAt(source, law.stiffness) * law.stiffness;
  if (pressed != source.depth) {
    const double stated = law.stiffness * (pressed / source.depth);
    law.damping += step * (law.stiffness - stated);
    law.stiffness = stated;
  }
  point.m_combinedContactStiffness1 = static_cast<btScalar>(law.stiffness);
  point.m_combinedContactDamping1 = static_cast<btScalar>(law.damping);
}

}  // namespace cloudcontact
