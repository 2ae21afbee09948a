// What hits add up to: in a bin, in a patch. All sums are kept about a place of their own: a far
// origin would cancel in them (DESIGN.md, "The method", 10).
#pragma once

#include "contact/hit_columns.h"
#include "kernels/contact/hit_bins.h"

#include <span>

namespace cloudcontact {

// What one body's samples say (outward normals of that body; forces in units of area times depth).
struct SideSums {
  Vec3 push = Vec3::Zero();    // sum a d n [m^3]
  Vec3 moment = Vec3::Zero();  // sum a d (x - origin) x n [m^4]
  Vec3 wall = Vec3::Zero();  // the part of `push` by samples that do not face the other body [m^3]
  double size = 0;           // sum a d [m^3]
  double depth[3] = {0, 0, 0};  // sum a d^k, of facing samples, k = 1..3
};

// A bin, or a patch of bins: sums over its hits about `origin` (frame body). Laid out as CcSums
// (kernels/hit_sums.h), which adds them up.
struct Sums {
  Vec3 origin = Vec3::Zero();
  SideSums side[2];           // by whose surface pushes: A's normals, B's normals
  double area = 0;            // wet, of facing samples, both bodies' together [m^2]
  double width = 0;           // sum over these of a times the sample's whole area [m^4]
  double facing = 0;          // sum a d, of facing samples, both bodies' together [m^3]
  Vec3 first = Vec3::Zero();  // sum a x
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  // sum a x x^T
  Vec3 normal[2] = {Vec3::Zero(), Vec3::Zero()};     // sum a n, of A's and of B's surface
  Eigen::Matrix3d normalBy[2] = {Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};  // sum a n x^T
  // Of facing samples by their pressed volume (these sum to `facing`), both bodies' together:
  // places, depth at the sample's middle, outward normals of A and B together, and these times the
  // place.
  Vec3 place = Vec3::Zero();  // [m^4]
  double middle = 0;          // [m^4]
  Vec3 apart = Vec3::Zero();  // [m^3]
  double opening = 0;         // [m^4]
  double deepest = -1e300;    // largest depth at a sample itself [m]
  double deep = 0;            // of `side.size`, by samples below the band
  int hits = 0;

  void clear();                 // but for its origin
  void add(const Sums& other);  // moved to this origin
  Vec3 center() const { return area > 0 ? Vec3(origin + first / area) : origin; }
};

// Hits of one body in one bin, by their numbers, at least one, and where they are added up: about
// to->origin. What `to` holds beside that is lost where the run is its first.
struct HitRun {
  const std::uint32_t *first, *last;
  Sums* to;
  Side side;
  bool begins;
};

// Adds runs up, all but Sums::deep; `gate` holds for every hit how far it faces the other body,
// 0..1; `unit` [m]: a length of the size of what is summed. Of contacts in which both bodies have
// samples: eight runs side by side.
void addRuns(const HitColumns& hits, const float* gate, std::span<const HitRun> runs, double unit);
// A run of a contact in which the other body is a shape without samples, and each hit stands for
// its surface too.
void addHits(const HitColumns& hits, const float* gate, const HitRun& run, double unit);
// Sums::deep.
void addDeep(const HitColumns& hits, const HitRun& run);

}  // namespace cloudcontact
