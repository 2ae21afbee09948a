// What a pair asks of ContactFinder, read from Bullet's wrappers; told from another to the bit.
#pragma once

#include <cloudcontact/contact/contact.h>

#include "bullet/pair_law.h"
#include "bullet/shape_conversion.h"

namespace cloudcontact {

struct PairQuery {
  ContactBody a, b;
  ContactSettings settings;
  PairLaw law;
  double voxel = 0;  // the smaller of the bodies' [m]
  double mass = 0;   // [kg] 1 / (1/mA + 1/mB); 0 where neither moves
  // How often the bodies' shapes were converted: a conversion may be made anew in its place.
  int conversions = 0;
  const char* wrong = nullptr;  // why nothing can be asked, then the rest is unset
};

// Whether ContactFinder is given the same by both: the same bodies, and not a bit of a pose, a
// motion or a setting different.
bool sameQuestion(const PairQuery& x, const PairQuery& y);

// Of one pair; keeps what it converted.
class PairReader {
 public:
  // `steps`: Bullet steps, and bodies about to touch get points too: without them a body that has
  // lifted off by a micrometre falls freely for a step, 0.04 mm at 480 Hz, and rattles for ever.
  // Throws as lawOf().
  PairQuery read(const CloudContactSettings& settings, const btCollisionObjectWrapper& a,
                 const btCollisionObjectWrapper& b, double step, bool steps);

 private:
  ConversionCache shapeA_, shapeB_;
};

}  // namespace cloudcontact
