// Cuts by an area: see cutter.h and kernels/cut/area_left.h.
#include "workpiece/area_cut.h"

#include <cloudcontact/workpiece/cutter.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace cloudcontact {

namespace {

// In the frame of the grid's body.
struct AreaInBody {
  int kind;
  Pose place;
  Vec3 size, reach;  // [m]; reach: of the bounds, from the middle
};

struct InBody {
  Pose place;

  AreaInBody operator()(const Sphere& s) const {
    const Vec3 size = Vec3::Constant(s.radius);
    return {CC_SPHERE, {Eigen::Quaterniond::Identity(), place.position}, size, size};
  }
  AreaInBody operator()(const Box& b) const {
    return {CC_BOX, place, b.halfExtents,
            place.orientation.toRotationMatrix().cwiseAbs() * b.halfExtents};
  }
  AreaInBody operator()(const Ellipsoid& e) const {
    const Eigen::Matrix3d axes = place.orientation.toRotationMatrix() * e.semiAxes.asDiagonal();
    return {CC_ELLIPSOID, place, e.semiAxes, axes.rowwise().norm()};
  }
  // The kernel does not support the other kinds. Their bounding box takes their place.
  template <typename Kind>
  AreaInBody operator()(const Kind& kind) const {
    const Eigen::AlignedBox3d bounds = boundsOf(kind);
    const Pose middle{place.orientation, place.toWorld(bounds.center())};
    return InBody{middle}(Box{0.5 * bounds.sizes()});
  }
};

int leftBy(const PlacedSolid& area, const VoxelGrid& grid, const Pose& toArea,
           const VoxelIndex& v) {
  const Vec3 center = grid.origin + grid.voxelSize * (v.cast<double>() + Vec3::Constant(0.5));
  const double depth = depthOf(area, toArea.toWorld(center)) / grid.voxelSize;
  return 255 - static_cast<int>(255 * std::clamp(depth + 0.5, 0.0, 1.0) + 0.5);
}

}  // namespace

bool kernelKnows(const PlacedSolid& area) {
  return std::holds_alternative<Sphere>(area.solid) || std::holds_alternative<Box>(area.solid) ||
         std::holds_alternative<Ellipsoid>(area.solid);
}

CcArea areaInGrid(const VoxelGrid& grid, const PlacedSolid& area, const Pose& place) {
  validate(area);
  if (!place.position.allFinite() || !place.orientation.coeffs().allFinite() ||
      !(place.orientation.norm() > 0))
    throw std::invalid_argument("the area's pose must be finite");
  Pose frame = place;
  frame.orientation.normalize();
  const AreaInBody p = std::visit(InBody{frame * area.place}, area.solid);
  const Eigen::Matrix3d turn = p.place.orientation.toRotationMatrix().transpose();
  const double perVoxel = 1 / grid.voxelSize;
  const Vec3 middle = perVoxel * (p.place.position - grid.origin), size = perVoxel * p.size;
  CcArea a{};
  a.kind = p.kind;
  for (int k = 0; k < 3; ++k) {
    // The area reaches voxels whose centers are half a voxel outside; the rest is for rounding.
    const double reach = perVoxel * p.reach[k] + 1, end = grid.size[k];
    a.low[k] = static_cast<int>(std::clamp(std::floor(middle[k] - reach - 0.5), 0.0, end));
    a.high[k] = static_cast<int>(std::clamp(std::ceil(middle[k] + reach - 0.5), -1.0, end - 1));
    a.middle[k] = middle[k];
    a.size[k] = size[k];
    for (int i = 0; i < 3; ++i) a.turn[3 * k + i] = turn(k, i);
  }
  return a;
}

void listCuts(const VoxelGrid& grid, const PlacedSolid& area, const Pose& place,
              std::vector<VoxelCut>& cuts) {
  const CcArea a = areaInGrid(grid, area, place);
  const bool known = kernelKnows(area);
  Pose frame = place;
  frame.orientation.normalize();
  const Pose toArea = frame.inverse();
  for (int z = a.low[2]; z <= a.high[2]; ++z)
    for (int y = a.low[1]; y <= a.high[1]; ++y)
      for (int x = a.low[0]; x <= a.high[0]; ++x) {
        const int left = known ? ccAreaLeaves(&a, x, y, z) : leftBy(area, grid, toArea, {x, y, z});
        if (left < 255) cuts.push_back({{x, y, z}, static_cast<std::uint8_t>(left)});
      }
}

std::vector<VoxelCut> cutsOf(const BaseVectorField& workpiece, const PlacedSolid& area,
                             const Pose& tool) {
  std::vector<VoxelCut> cuts;
  listCuts({workpiece.voxelSize(), workpiece.origin(), workpiece.size()}, area, tool, cuts);
  return cuts;
}

std::vector<VoxelCut> cutsOf(const Cloud& workpiece, const PlacedSolid& area, const Pose& tool) {
  std::vector<VoxelCut> cuts;
  listCuts({workpiece.voxelSize(), workpiece.origin(), workpiece.size()}, area, tool, cuts);
  return cuts;
}

}  // namespace cloudcontact
