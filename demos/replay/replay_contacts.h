// The contacts of a replay in each of its frames.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "scene/world.h"

namespace cloudcontact::program {

// A contact point, in single precision for display.
struct ReplayPoint {
  Eigen::Vector3f position;  // in the take [m]
  Eigen::Vector3f force;     // of body a on body b [N]
  float depth = 0;           // [m]
};

// A patch, shown as a disc with the second moment of its points.
struct ReplayPatch {
  int a = -1, b = -1;                   // indices of bodies; a fixed body is a
  std::uint32_t first = 0, points = 0;  // in ReplayContacts::points
  Eigen::Vector3f position, normal;     // from a to b
  float radius = 0, depth = 0;          // [m]
};

// The patches of all frames. A patch without a visible change is not stored again: a heap at rest
// costs four bytes per patch and frame.
class ReplayContacts {
 public:
  // `still` is the invisible motion of a point [m].
  explicit ReplayContacts(double still = 0) : still_(static_cast<float>(still)) {}

  // Adds the contacts of a frame. `isFixed` marks bodies that never move: arrows show the forces on
  // moving ones.
  void add(const ContactsNow& now, const std::vector<bool>& isFixed);
  void thin();  // keeps every other frame

  float still() const { return still_; }
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
  float mostForce_ = 0, mostDepth_ = 0;  // so far; gaps are no depths
  std::vector<ReplayPatch> patches_;
  std::vector<ReplayPoint> points_;
  std::vector<std::uint32_t> shown_;   // of all frames
  std::vector<std::size_t> shownEnd_;  // of each frame, one past its last
};

}  // namespace cloudcontact::program
