// Hits, one column for each quantity.
#pragma once

#include "kernels/contact/sample.h"

#include <cloudcontact/field/surface_field.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace cloudcontact {

enum Side : int { kA = 0, kB = 1 };

// A sample found in the other body, or close to it.
struct Hit {
  Eigen::Vector3f position;             // midway between the two surfaces, frame body [m]
  Eigen::Vector3f own;                  // outward normal of the body that the sample belongs to
  Eigen::Vector3f other;                // outward normal of the body that it lies in
  float area;                           // [m^2]
  float share, depth1, depth2, depth3;  // of CcWet (kernels/contact/sample.h) [1, m, m^2, m^3]
  float depth;                          // at the sample itself, negative outside [m]
  float facing;                         // cosine between own and -other
  std::int8_t side;                     // whose sample it is
  std::int8_t deep;                     // 1: below the band
};

// `area` [m^2], `depth` [m] at the sample.
Hit hitOf(const CcHit& hit, float area, float depth, Side side, bool deep);
// Makes a hit `depth` [m] deep all over its area, above 0.
void setDepth(Hit& hit, float depth);

// Hits in columns. It keeps its memory when cleared.
class HitColumns {
 public:
  // Pointers into the columns.
  template <typename Number>
  struct Columns {
    Number *x, *y, *z, *ownX, *ownY, *ownZ, *otherX, *otherY, *otherZ;
    Number *area, *share, *depth1, *depth2, *depth3, *depth, *facing;
  };

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  void clear() {
    size_ = 0;
    anyDeep_ = false;
  }
  Columns<const float> columns() const { return at<const float>(data_.data(), 0); }
  const std::int8_t* sides() const { return side_.data(); }
  std::size_t countOf(Side side) const {
    return static_cast<std::size_t>(std::count(side_.begin(),
                                               side_.begin() + static_cast<std::ptrdiff_t>(size_),
                                               static_cast<std::int8_t>(side)));
  }
  Side side(std::size_t i) const { return static_cast<Side>(side_[i]); }
  bool deep(std::size_t i) const { return deep_[i] != 0; }
  bool anyDeep() const { return anyDeep_; }

  // Makes room for `more` hits after the last. commit() then adds the first `count` of them.
  Columns<float> room(std::size_t more) {
    if (size_ + more > side_.size()) enlarge(size_ + more);
    return at<float>(data_.data(), size_);
  }
  void commit(std::size_t count, Side side, bool deep);
  void push_back(const Hit& hit);
  void append(const HitColumns& from);
  // Reserves what `other` has reserved.
  void reserveLike(const HitColumns& other) {
    if (other.side_.size() > side_.size()) move(other.side_.size());
  }
  Hit operator[](std::size_t i) const;

 private:
  static constexpr std::size_t kColumns = 16;

  template <typename Number>
  Columns<Number> at(Number* data, std::size_t i) const {
    const auto c = [&](std::size_t k) { return data + k * side_.size() + i; };
    return {c(0), c(1), c(2),  c(3),  c(4),  c(5),  c(6),  c(7),
            c(8), c(9), c(10), c(11), c(12), c(13), c(14), c(15)};
  }
  void enlarge(std::size_t size);
  void move(std::size_t room);

  std::size_t size_ = 0;
  bool anyDeep_ = false;
  std::vector<float> data_;  // column after column
  std::vector<std::int8_t> side_, deep_;
};

}  // namespace cloudcontact
