// Hits, a column a quantity; keeps its memory.
#pragma once

#include "sample.h"

#include <cloudcontact/surface_field.h>

#include <array>
#include <cstdint>
#include <vector>

namespace cloudcontact {

enum Side : int { kA = 0, kB = 1 };

// A sample found in (or within reach of) the other body.
struct Hit {
  Eigen::Vector3f position;             // midway between the two surfaces, frame body [m]
  Eigen::Vector3f own;                  // outward normal of the body that the sample belongs to
  Eigen::Vector3f other;                // outward normal of the body that it lies in
  float area;                           // [m^2]
  float share, depth1, depth2, depth3;  // kernels/sample.h [1, m, m^2, m^3]
  float depth;                          // at the sample itself, negative outside [m]
  float facing;                         // cosine between own and -other
  std::int8_t side;                     // whose sample it is
  std::int8_t deep;                     // 1: deeper than the band knows
};

class HitColumns {
 public:
  enum Column { X, Y, Z, OwnX, OwnY, OwnZ, OtherX, OtherY, OtherZ, Area, Share, Depth1, Depth2,
                Depth3, Depth, Facing, kColumns };

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  void clear() { size_ = 0; }
  const float* column(Column c) const { return columns_[c].data(); }
  std::int8_t side(std::size_t i) const { return side_[i]; }

  // Room for `more` hits behind the last; `commit` makes the first of them hits of that side.
  struct Room {
    float* column[kColumns];
  };
  Room room(std::size_t more) {
    if (size_ + more > side_.size()) enlarge(size_ + more);
    Room r;
    for (int c = 0; c < kColumns; ++c) r.column[c] = columns_[static_cast<std::size_t>(c)].data() + size_;
    return r;
  }
  void commit(std::size_t count, Side side, bool deep) {
    for (std::size_t i = size_; i < size_ + count; ++i) {
      side_[i] = static_cast<std::int8_t>(side);
      deep_[i] = static_cast<std::int8_t>(deep);
    }
    size_ += count;
  }
  void push_back(const Hit& hit);
  Hit operator[](std::size_t i) const;

 private:
  void enlarge(std::size_t size);

  std::size_t size_ = 0;
  std::array<std::vector<float>, kColumns> columns_;
  std::vector<std::int8_t> side_, deep_;
};

}  // namespace cloudcontact
