// Reduces a body's motion to few keys. Between keys a viewer interpolates linearly (glTF's LINEAR),
// and every point of the body stays within a tolerance of the simulation.
#pragma once

#include <cloudcontact/base/pose.h>

#include <vector>

namespace cloudcontact::program {

struct PoseKey {
  double time = 0;  // [s]
  Pose pose;
};

// The interpolated pose between two keys.
Pose between(const PoseKey& from, const PoseKey& to, double time);

class Keyframes {
 public:
  // Points within `reach` of the body's origin deviate by at most `tolerance` [m].
  Keyframes(double reach, double tolerance) : reach_(reach), tolerance_(tolerance) {}

  void add(double time, const Pose& pose);
  void finish();  // processes the last poses; add() must not follow
  const std::vector<PoseKey>& keys() const { return keys_; }

 private:
  void thin();

  double reach_, tolerance_;
  std::vector<PoseKey> keys_;     // done
  std::vector<PoseKey> waiting_;  // poses since the last key, with that key first
};

}  // namespace cloudcontact::program
