// What the cases are put together from.
#pragma once

#include <memory>
#include <mutex>

#include "lab/cases.h"

namespace cloudcontact::program::lab {

// Bodies whose grid lies anyhow.
LabBody primitiveBody(const std::string& name, const Solid& shape, Random& random);
LabBody halfSpaceBody();
LabBody meshBody(const std::string& name, std::function<Mesh(double tolerance)> mesh,
                 Random& random, bool convex = false);

// About z, turned by any angle: where facets mirror each other, errors of methods that take
// triangles would cancel.
LabBody torusBody(Random& random, double ring, double wire);

Pose at(double x, double y, double z,
        const Eigen::Quaterniond& turn = Eigen::Quaterniond::Identity());
Eigen::Quaterniond turnX(double angle);
Eigen::Quaterniond turnY(double angle);
Eigen::Quaterniond turnZ(double angle);

// A placement a depth: `pose` says where B stands pressed by that much. A truth's `depth` becomes
// it; `deepest` is given as a share of it.
std::vector<Placement> pressed(const std::vector<double>& depths,
                               const std::function<Pose(double depth)>& pose, const Truth& truth);
// What `make` gives, made at the first call: a truth by quadrature takes seconds, and is the same
// whatever the grids.
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
// kDepths of a size, none above `most`.
std::vector<double> depthsOf(double size, double most = 1e9);

}  // namespace cloudcontact::program::lab
