// The second half of a query, first step: hits gathered in bins, an 8-voxel cell times one of six
// directions each, and bins grown together to patches. All sums are kept about the bin's own
// centre: a far origin would cancel in them (DESIGN.md, "The method", 10).
#pragma once

#include "hits.h"

#include <cstdint>
#include <vector>

namespace cloudcontact {

// What one body's samples say (outward normals of that body; forces in units of area times depth).
struct SideSums {
  Vec3 push = Vec3::Zero();    // sum a d n [m^3]
  Vec3 moment = Vec3::Zero();  // sum a d (x - origin) x n [m^4]
  Vec3 wall = Vec3::Zero();  // the part of `push` by samples that do not face the other body [m^3]
  double size = 0;           // sum a d [m^3]
  double depth[3] = {0, 0, 0};  // sum a d^k, of facing samples, k = 1..3
};

// A bin, or a patch of bins: sums over its hits about `origin` (frame body).
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

  void add(const Hit& hit, bool oneSided);
  void add(const Sums& other);  // moved to this origin
  Vec3 center() const { return area > 0 ? Vec3(origin + first / area) : origin; }
};

// Groups hits into patches; keeps its memory.
class Binner {
 public:
  // Sums of each patch, in a fixed order. `oneSided`: the other body is a shape without
  // samples, and each hit stands for its surface too.
  const std::vector<Sums>& patches(const HitColumns& hits, double cell, bool oneSided);

 private:
  struct Bin {
    std::int32_t cell[3];
    std::int32_t direction;
    std::int32_t next;  // another bin of the same cell, -1: none
    std::int32_t patch;
    Sums sums;
  };
  std::size_t binOf(const Hit& hit, double cell);
  void enlarge();
  // The first bin of a cell, or -1 less the free slot of the table where it belongs.
  std::int32_t find(const std::int32_t* cell) const;
  void layOut();
  // The same once all bins are there, negative where there is none.
  std::int32_t firstIn(const std::int32_t* cell) const;
  static bool alike(const Sums& a, const Sums& b, double agree);
  bool linked(const Bin& bin, const Bin& from, const Sums& patch, double close) const;
  void grow(std::size_t seed, Sums& patch, std::int32_t number, double close);

  std::vector<Bin> bins_;
  std::vector<std::int32_t> table_;  // a cell's first bin, open addressing, -1 empty
  std::vector<std::int32_t> box_;    // the same as a box of cells, empty where that is large
  std::int32_t low_[3] = {}, span_[3] = {};
  std::size_t cells_ = 0;
  double perCell_ = 0;  // [1/m]
  std::vector<std::uint32_t> order_, queue_;
  std::vector<Sums> patches_;
};

}  // namespace cloudcontact
