// How many times faster one method is than another at the same error: ours against every peer's
// setting, family by family.
#pragma once

#include <string>
#include <vector>

#include "lab/chart.h"

namespace cloudcontact::program::lab {

// On the cases of the family that the peer's setting answers, and on no others.
struct PeerRatio {
  std::string family, method, setting;
  bool convex = false;
  int cases = 0, of = 0;                   // that the peer answers, of the family's
  int wrong = 0;                           // of them: answered with a wrong depth (answer.h)
  double microseconds = 0, normalDeg = 0;  // the peer's: geometric mean, mean
  double allowedDeg = 0;                   // what ours may err: as much as the peer, or 1 deg
  std::string ours = {};                   // the fastest setting of ours that does; empty: none
  double oursMicroseconds = kUnknown, oursNormalDeg = kUnknown;
  double timesFaster = kUnknown;  // the peer's time by ours: below 1, ours is slower
};

// Ours no less accurate than the peer. A peer whose depth is wrong is taken by its normal.
std::vector<PeerRatio> peerRatios(const std::vector<ChartRow>& rows);
// Convex families: ours within a degree against GJK and EPA on the hull of the coarsest mesh (642
// vertices on the spheres), whatever that errs.
std::vector<PeerRatio> hullRatios(const std::vector<ChartRow>& rows);

// "gimpact (facets 1/500): 2.1 deg in 900 us; ours (voxel = size / 8): ..., 45 times faster".
std::string inWords(const PeerRatio& ratio);
// "45 times faster", "3 times slower", "none of ours is as accurate".
std::string verdictOf(const PeerRatio& ratio);

}  // namespace cloudcontact::program::lab
