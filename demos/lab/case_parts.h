// What the cases are put together from.
#pragma once

#include "lab/cases.h"

namespace cloudcontact::program::lab {

// Bodies whose grid lies anyhow.
LabBody primitiveBody(const std::string& name, const AnalyticShape& shape, Random& random);
LabBody halfSpaceBody();
LabBody meshBody(const std::string& name, std::function<Mesh(double tolerance)> mesh,
                 Random& random, bool convex = false);

Pose at(double x, double y, double z,
        const Eigen::Quaterniond& turn = Eigen::Quaterniond::Identity());
Eigen::Quaterniond turnX(double angle);
Eigen::Quaterniond turnY(double angle);
Eigen::Quaterniond turnZ(double angle);

// A placement a depth: `pose` says where B stands pressed by that much.
std::vector<Placement> pressed(const std::vector<double>& depths,
                               const std::function<Pose(double depth)>& pose, const Truth& truth);
// kDepths of a size, none above `most`.
std::vector<double> depthsOf(double size, double most = 1e9);

}  // namespace cloudcontact::program::lab
