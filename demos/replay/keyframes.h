// A body's motion as few keys as it takes: between two keys a viewer moves on a straight line and
// turns at an even rate (glTF's LINEAR), and no point of the body is ever further than a tolerance
// from where the simulation had it.
#pragma once

#include <cloudcontact/base/pose.h>

#include <vector>

namespace cloudcontact::program {

struct PoseKey {
  double time = 0;  // [s]
  Pose pose;
};

// Where a viewer shows the body between two keys.
Pose between(const PoseKey& from, const PoseKey& to, double time);

class Keyframes {
 public:
  // No point within `reach` of the body's origin strays further than `tolerance` [m].
  Keyframes(double reach, double tolerance) : reach_(reach), tolerance_(tolerance) {}

  void add(double time, const Pose& pose);
  void finish();  // what is still waiting; nothing may be added after it
  const std::vector<PoseKey>& keys() const { return keys_; }

 private:
  void thin();

  double reach_, tolerance_;
  std::vector<PoseKey> keys_;     // done
  std::vector<PoseKey> waiting_;  // since the last of them, which is the first here
};

}  // namespace cloudcontact::program
