// Where the other body's surface is smooth about a touched sample, its depth there is a quadric,
// found from looks at four places beside the sample. It tells the depths of all the sample's
// voxels, which need no looks of their own.
#pragma once

#include "contact/lanes.h"

namespace cloudcontact::search {

// The depth at x, r = x - at: depth - n.r - r.H.r / 2 [voxels].
struct DepthQuadric {
  bool smooth;  // else the rest says nothing
  float at[3], n[3], depth;
  float h[6];  // H / 2: xx, yy, zz, twice xy, xz, yz
};

// Samples of which quadrics are wanted.
struct SmoothRuns {
  static constexpr int kMost = kLanes / 4;

  int count = 0;
  TouchedSample touched[kMost];
  DepthQuadric quadric[kMost];
  float t1[kMost][3], t2[kMost][3], aside[kMost];  // the four places: along the tangents
  Lanes places;

  bool full() const { return count == kMost; }
  void add(const Direction& dir, const OwnedVoxels::Level& level, const TouchedSample& one);
  void findQuadrics(const Direction& dir, const FieldData& other);
};

}  // namespace cloudcontact::search
