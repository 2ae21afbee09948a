// Building blocks of the cases: random numbers, bodies, poses and placements.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>

#include "lab/cases.h"

namespace cloudcontact::program::lab {

// SplitMix64 (Steele, Lea, Flood 2014): equal numbers on every platform.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform(double low, double high);
  Eigen::Quaterniond rotation();  // uniform over all rotations
  Pose grid(double voxel);        // random rotation, shift by less than a voxel

 private:
  std::uint64_t state_;
};

// Bodies with a voxel grid in a random pose.
LabBody primitiveBody(const std::string& name, const Solid& shape, Random& random);
LabBody halfSpaceBody();
LabBody meshBody(const std::string& name, std::function<Mesh(double tolerance)> mesh,
                 Random& random, bool convex = false);

// A torus about z, turned about z by a random angle. With facets that mirror each other, errors of
// methods that take triangles would cancel.
LabBody torusBody(Random& random, double ring, double wire);

Pose at(double x, double y, double z,
        const Eigen::Quaterniond& turn = Eigen::Quaterniond::Identity());
Eigen::Quaterniond turnX(double angle);
Eigen::Quaterniond turnY(double angle);
Eigen::Quaterniond turnZ(double angle);

// One placement per depth: `pose` returns B's pose pressed in by that depth. Sets `depth` of the
// truth; `deepest` is given as a multiple of the depth.
std::vector<Placement> pressed(const std::vector<double>& depths,
                               const std::function<Pose(double depth)>& pose, const Truth& truth);
// Calls `make` at the first use and keeps its result: a truth by quadrature takes seconds and does
// not depend on the grids.
template <class Made>
std::function<const Made&()> once(std::function<Made()> make) {
  struct Kept {
    std::once_flag flag;
    std::optional<Made> made;
  };
  return [kept = std::make_shared<Kept>(), make]() -> const Made& {
    std::call_once(kept->flag, [&] { kept->made = make(); });
    return *kept->made;
  };
}
// kDepths times the size, clamped to `most`.
std::vector<double> depthsOf(double size, double most = 1e9);

}  // namespace cloudcontact::program::lab
