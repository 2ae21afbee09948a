// KeptGap: how far two bodies are surely apart, found once and spent by their motion. In a heap
// most pairs whose boxes meet do not touch, and stay apart for many steps.
//
// The gap is a lower bound on the distance between the surfaces, by balls around their samples: it
// is short of it by half at most, or by the diameters of two of the coarsest samples' cells. Where
// it is less than is asked, it is not looked for again before the bodies have moved by what was
// missing.
#pragma once

#include <cloudcontact/contact/contact.h>

#include <cstddef>

namespace cloudcontact {

class KeptGap {
 public:
  // A ball around a body, in its own frame [m], and where the body was as the other sees it.
  struct Side {
    Vec3 center = Vec3::Zero();
    double radius = 0;
    Pose inOther;
  };

  // Finds the gap of two bodies with fields, if it may be above `least` [m].
  void keep(const ContactBody& a, const ContactBody& b, double least);
  void drop() { kept_ = false; }
  // Whether bodies at these poses are surely more than keep()'s `least` apart.
  bool holds(const Pose& a, const Pose& b) const { return kept_ && gap_ - moved(a, b) > least_; }
  std::size_t compared() const { return compared_; }  // pairs of balls in all keep()

 private:
  double moved(const Pose& a, const Pose& b) const;

  Side sides_[2];
  bool kept_ = false;
  double gap_ = 0, least_ = 0;  // [m] of sides_; a gap of at most `least_` is known from above
  std::size_t compared_ = 0;
};

}  // namespace cloudcontact
