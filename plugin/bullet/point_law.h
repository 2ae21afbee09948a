// The row of a contact's point in Bullet's solver: its share of the pair's law, and how fast that
// grows.
//
// The law is one spring a pair, FR = k d, whose force is shared out by pressure. So it grows by k
// as the bodies come nearer, but as they turn, it moves between pointed places by (1 + b) k
// (ContactResult::pointed): by twice k between the balls that a body stands on, by three times k
// between its corners. A row has one slope for both. With k alone, a stiff step turns a body back
// by 1 + b times what is too much: a table on four tips rattles forever, and crates whose springs
// give less than their faces are uneven fall. So rows grow by the mean of both, with which any step
// leaves at most half of either. A common spring in series with steeper rows would be exact, but
// Bullet's rows know two bodies and no spring between rows.
#pragma once

#include "bullet/step_adjustments.h"

namespace cloudcontact {

class PointLaw {
 public:
  PointLaw(const ContactResult& contact, const PairSides& sides, const WriteSettings& settings);
  // Sets stiffness and damping.
  void write(const ContactPoint& source, btManifoldPoint& point) const;

 private:
  KelvinVoigt shareOf(const ContactPoint& source, double pressed) const;
  double growthAt(const ContactPoint& source, double stiffness) const;

  const PairSides& sides_;
  const WriteSettings& settings_;
  std::optional<SpringTangent> tangent_;  // of WriteSettings::automatic, per unit of share
  double slope_ = 0;                      // [N/m] sum of those of the points that touch
  double turning_ = 0;                    // what rows grow more than by it, over it, as bodies turn
};

}  // namespace cloudcontact
