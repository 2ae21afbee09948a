// How many times faster CloudContact is than a peer at the same error, for every setting of every
// peer, by family.
#pragma once

#include <string>
#include <vector>

#include "lab/chart_row.h"

namespace cloudcontact::program::lab {

// Over the family's cases that the peer answers at this setting.
struct PeerRatio {
  std::string family, method, setting;
  bool convex = false;
  int cases = 0, of = 0;                   // answered by the peer, of all in the family
  int wrong = 0;                           // of `cases`: with a wrong depth (kWrongDepth)
  double microseconds = 0, normalDeg = 0;  // of the peer: geometric mean, mean
  double allowedDeg = 0;                   // error allowed to CloudContact: the peer's, or 1 deg
  std::string ours = {};  // the fastest setting of CloudContact within it; empty: none
  double oursMicroseconds = kUnknown, oursNormalDeg = kUnknown;
  double timesFaster = kUnknown;  // peer's time / ours; below 1: CloudContact is slower
};

// CloudContact no less accurate than the peer. Peers with a wrong depth are still compared by their
// normals.
std::vector<PeerRatio> peerRatios(const std::vector<ChartRow>& rows);
// Convex families: CloudContact within 1 deg against GJK and EPA on the hull of the coarsest mesh
// (642 vertices on the spheres), whatever that hull's error.
std::vector<PeerRatio> hullRatios(const std::vector<ChartRow>& rows);

// "rings, Bullet GImpact (facets 1/500): 2.1 deg in 900 us; CloudContact (voxel = size / 8): ...,
// 45 times faster".
std::string inWords(const PeerRatio& ratio);
// "45 times faster", "3 times slower", "no setting of CloudContact is as accurate".
std::string verdictOf(const PeerRatio& ratio);

}  // namespace cloudcontact::program::lab
