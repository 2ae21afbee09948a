// The contacts of a replay: what touched what at each of its frames, for the eye.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "scene/world.h"

namespace cloudcontact::program {

// A point of a contact. Single precision: for the eye.
struct ReplayPoint {
  Eigen::Vector3f position;  // in the take [m]
  Eigen::Vector3f force;     // of body a on body b [N]
  float depth = 0;           // [m]
};

// Points that belong together, as a disc: it has the second moment of its points.
struct ReplayPatch {
  int a = -1, b = -1;                   // indices of bodies; where one is fixed, it is a
  std::uint32_t first = 0, points = 0;  // in ReplayContacts::points
  Eigen::Vector3f position, normal;     // from a to b
  float radius = 0, depth = 0;          // [m]
};

// A patch is stored once for as long as an eye sees no change in it: a heap at rest costs four
// bytes a patch and frame. Stored anew in each frame, the contacts of 30 resting boxes slowed a run
// of Bullet's own methods by 8 %, all of it the writing of memory.
class ReplayContacts {
 public:
  // `still` is how far a point may move unseen [m].
  explicit ReplayContacts(double still = 0) : still_(static_cast<float>(still)) {}

  // The contacts of one more frame. `isFixed` tells of a body whether it never moves: arrows show
  // the forces on what does.
  void add(const ContactsNow& now, const std::vector<bool>& isFixed);
  void thin();  // keeps every other frame

  std::size_t frames() const { return shownEnd_.size(); }
  // The patches of a frame, as indices.
  std::span<const std::uint32_t> shownAt(std::size_t frame) const;
  std::span<const ReplayPoint> of(const ReplayPatch& patch) const {
    return {points_.data() + patch.first, patch.points};
  }
  const std::vector<ReplayPatch>& patches() const { return patches_; }
  const std::vector<ReplayPoint>& points() const { return points_; }
  const std::vector<std::uint32_t>& shown() const { return shown_; }

 private:
  struct Seen;
  bool looksTheSame(const ReplayPatch& stored, const Seen& patch) const;
  void store(const Seen& patch);

  float still_;
  float mostForce_ = 0, mostDepth_ = 0;  // so far
  std::vector<ReplayPatch> patches_;
  std::vector<ReplayPoint> points_;
  std::vector<std::uint32_t> shown_;   // of all frames
  std::vector<std::size_t> shownEnd_;  // of each frame, one past its last
};

}  // namespace cloudcontact::program
