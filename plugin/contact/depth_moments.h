// The depth of the deepest point of a contact from sums over its area.
#pragma once

#include <algorithm>

namespace cloudcontact {

constexpr double kMostPointed = 2.0;  // b of a corner; noise alone would go on

// `moments`: M_k = sum of area times depth^k, k = 1..3. If the part of the area deeper than t
// falls like (1 - t/d)^b (b = 0 a face, 1/2 a cylinder's side, 1 a sphere or an edge, 2 a corner),
// then M2/M1 = 2 d / (2 + b) and M3/M2 = 3 d / (3 + b), which two ratios give b and d.
inline double deepestByMoments(const double* moments) {
  if (!(moments[0] > 0) || !(moments[1] > 0)) return 0;
  const double ratio = moments[2] * moments[0] / (moments[1] * moments[1]);
  const double b =
      ratio >= 1.4 ? kMostPointed : std::clamp(3 * (ratio - 1) / (1.5 - ratio), 0.0, kMostPointed);
  return (1 + 0.5 * b) * moments[1] / moments[0];
}

}  // namespace cloudcontact
