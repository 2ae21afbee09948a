// Names that patches keep from step to step, so that a solver finds their points again.
#pragma once

#include <cloudcontact/base/pose.h>

#include <cstdint>
#include <vector>

namespace cloudcontact {

// In A's frame, for the frame body may be the other one in the next step: where two equal links
// hung in each other their points lost their names, and the solver what it had learnt, several
// times a second.
struct NamedPatch {
  Vec3 center, normal;
  std::uint32_t id = 0;
};

class PatchNames {
 public:
  // Gives each of a step's patches, in their order, the id of the nearest of the step before that
  // is like it and still free, or a new one; and remembers them in its place.
  void name(std::vector<NamedPatch>& patches, double voxel);

 private:
  std::vector<NamedPatch> known_;
  std::uint32_t next_ = 0;
};

}  // namespace cloudcontact
