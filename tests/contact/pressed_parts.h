// Parts by formula, as meshes, fields and distances, and pairs of them pressed together: for tests
// of where contacts are and how deep. Lengths in the functions' arguments are voxels.
#pragma once

#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/mesh/mesh.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace cloudcontact::testing {

struct Part {
  double voxel;                                // [m]
  Mesh mesh;                                   // [m]
  std::function<double(const Vec3&)> outside;  // distance to the surface, negative inside [m]
  std::shared_ptr<const SurfaceField> field;   // on a grid that is turned and shifted
  Pose grid;

  ContactBody at(const Pose& pose) const;
};

// How deep two parts are in each other [m]: the farthest that a point of one surface, by its mesh,
// is inside the other, by its formula.
double overlapOf(const Part& a, const Pose& poseA, const Part& b, const Pose& poseB);

// Two parts pressed together.
struct PressedPair {
  std::string name;
  std::shared_ptr<const Part> a, b;
  Pose poseA, poseB;
  double overlap;  // [m]
};

// Pairs by their kind: "tori", "rings", "pegs", "boxes", "corners", "round" or "threads".
std::vector<PressedPair> pressedPairs(const std::string& kind);

}  // namespace cloudcontact::testing
