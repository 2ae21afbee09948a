// Adds hits up in bins: CcSums (kernels/contact/hit_sums.h), about an origin near the hits, since a
// far origin cancels (docs/force.md, "Bins").
#pragma once

#include "contact/hit_columns.h"
#include "kernels/contact/hit_bins.h"

#include <span>

namespace cloudcontact {

// Some hits of one body in one bin, at least one.
struct HitRun {
  const std::uint32_t *first, *last;  // numbers of the hits
  CcSums* to;                         // receives the sums, about to->origin
  Side side;                          // of the body whose samples hit
  bool begins;                        // the bin's first run: clears `to` but for its origin
};

// Adds runs of a contact of two clouds, eight runs side by side; all but CcSums::deep. `gate`: for
// each hit, how far it faces the other body, 0..1. `unit`: a length of the size of a bin [m].
void addRuns(const HitColumns& hits, const float* gate, std::span<const HitRun> runs, double unit);
// Adds a run of a contact of a cloud and a shape. Shapes have no samples, so each hit also stands
// for the shape's surface.
void addHits(const HitColumns& hits, const float* gate, const HitRun& run, double unit);
// Adds CcSums::deep.
void addDeep(const HitColumns& hits, const HitRun& run);

// The center of the area in contact, or the origin if there is none.
CcVec centerOf(const CcSums& sums);

}  // namespace cloudcontact
