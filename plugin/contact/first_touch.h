// FirstTouch: when two moving bodies first touch. For bodies that move so far in a step that they
// would be through each other before the next query (continuous collision detection).
//
// Conservative advancement: far bodies move on by a lower bound of their gap over their greatest
// speed of approach. The bound comes from balls around the bricks of one body's samples, looked up
// in the other's coarse distances. Nearer than two voxels the pair is searched, and moves on by its
// gap, but a voxel at least: a wall of two voxels has no room for that. The last such motion is
// halved until the place is known, to a twentieth of a voxel, where they are half a voxel deep in
// each other: the contact has its normal there.
//
// Bodies that touch already are stopped where they touch, as a solver will, and the rest of their
// motion is looked at: a body that slides on a floor meets the wall. A search from time 0 does so.
#pragma once

#include <cloudcontact/contact/contact_finder.h>

#include <memory>
#include <optional>

namespace cloudcontact {

// A time at which bodies are half a voxel deep in each other [s], and how each has moved until
// then: a point of the body that was at x is at a.toWorld(x).
struct Touch {
  double time = 0;
  Pose a, b;
  // How much A's velocity over B's was less than that of the bodies [m/s]: what drove them into
  // each other where they touched at the start was taken from it.
  Vec3 checked = Vec3::Zero();
};

class FirstTouch {
 public:
  explicit FirstTouch(std::shared_ptr<ContactWorkspace> workspace);

  // Empty if there is no new touch between `from` and `until` [s]. Bodies as ContactFinder takes
  // them, where they are at time 0. Motions are finite.
  std::optional<Touch> find(const ContactBody& a, const ContactBody& b, double from, double until);
  // Of the last find(): Touch::checked, and how often the pair was searched.
  Vec3 checked() const { return velocity_ - startA_.motion.linear; }
  std::size_t searches() const { return searches_; }

 private:
  void place(double time);
  void search();
  void keepApart();
  double deepest() const;
  Touch between(double apart, double touching);

  ContactFinder finder_;
  ContactSettings settings_;
  ContactBody a_, b_, startA_, startB_;
  Pose fromA_, fromB_;            // poses at time 0, inverted
  Vec3 velocity_ = Vec3::Zero();  // of A, as given
  ContactResult found_;
  double start_ = 0;  // [s] when the bodies are at startA_ and startB_
  double voxel_ = 0, speed_ = 0, limit_ = 0;
  std::size_t searches_ = 0;
};

// Upper bound on the speed of points of one body as the other sees them [m/s].
double closingSpeed(const ContactBody& a, const ContactBody& b);
// The part of it that comes from a body's spin [m/s]. Of a body without end, as a half-space, it is
// that of the places where the other one is.
double spinSpeed(const ContactBody& body, const ContactBody& other);

}  // namespace cloudcontact
