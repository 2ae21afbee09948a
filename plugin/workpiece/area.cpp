// Depth, bounds and middles of areas: see area.h.
#include <cloudcontact/workpiece/area.h>

#include "field/cloud_depth.h"
#include "workpiece/area_point.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace cloudcontact {

namespace {

// Every voxel of a cloud's grid, in the order of memory.
template <typename What>
void forEachVoxel(const Eigen::Vector3i& size, What&& what) {
  for (int z = 0; z < size.z(); ++z)
    for (int y = 0; y < size.y(); ++y)
      for (int x = 0; x < size.x(); ++x) what(x, y, z);
}

// Of a box in a frame that is turned: the box about it.
Eigen::AlignedBox3d turned(const Pose& place, const Eigen::AlignedBox3d& box) {
  Eigen::AlignedBox3d bounds;
  for (int corner = 0; corner < 8; ++corner)
    bounds.extend(place.toWorld(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner))));
  return bounds;
}

struct Bounds {
  Eigen::AlignedBox3d operator()(const SphereArea& a) const {
    return {a.center - Vec3::Constant(a.radius), a.center + Vec3::Constant(a.radius)};
  }
  Eigen::AlignedBox3d operator()(const BoxArea& a) const {
    return turned(a.place, {-a.halfExtents, a.halfExtents});
  }
  Eigen::AlignedBox3d operator()(const EllipsoidArea& a) const {
    const Eigen::Matrix3d axes = a.place.orientation.toRotationMatrix() * a.semiAxes.asDiagonal();
    const Vec3 reach = axes.rowwise().norm();
    return {a.place.position - reach, a.place.position + reach};
  }
  Eigen::AlignedBox3d operator()(const CloudArea& a) const { return turned(a.place, a.matter); }
};

Eigen::AlignedBox3d matterOf(const Cloud& cloud) {
  Eigen::AlignedBox3d box;
  const double h = cloud.voxelSize();
  forEachVoxel(cloud.size(), [&](int x, int y, int z) {
    if (cloud.coverage(x, y, z) == 0) return;
    const Vec3 low = cloud.origin() + h * Vec3(x, y, z);
    box.extend(low).extend(low + Vec3::Constant(h));
  });
  return box;
}

// Where the depth has no direction, at a centre, any will do.
Vec3 unit(const Vec3& v) {
  const double length = v.norm();
  return length > 0 ? Vec3(v / length) : Vec3::UnitZ();
}

void requireSizes(const char* what, const Vec3& sizes, const Pose& place) {
  if (!(sizes.array() > 0).all() || !sizes.allFinite())
    throw std::invalid_argument(std::string(what) + " must be positive and finite");
  if (!place.position.allFinite() || !place.orientation.coeffs().allFinite())
    throw std::invalid_argument("an area's place must be finite");
}

}  // namespace

double depthOf(const BoxArea& a, const Vec3& point) {
  const Vec3 beyond = a.place.toLocal(point).cwiseAbs() - a.halfExtents;
  const double outside = beyond.cwiseMax(0.0).norm();
  return outside > 0 ? -outside : -beyond.maxCoeff();
}

double depthOf(const EllipsoidArea& a, const Vec3& point) {
  const Vec3 p = a.place.toLocal(point);
  const double r = p.cwiseQuotient(a.semiAxes).norm();
  // At the centre every direction is a ray; the shortest way out is along the least axis.
  if (r < 1e-12) return a.semiAxes.minCoeff();
  // The implicit function over its gradient: first order in the distance.
  const double slope = p.cwiseQuotient(a.semiAxes.cwiseProduct(a.semiAxes)).norm() / r;
  return std::min((1 - r) / slope, a.semiAxes.minCoeff());
}

double depthOf(const CloudArea& a, const Vec3& point) {
  return depthAt(*a.cloud, *a.depth, a.place.toLocal(point));
}

Vec3 normalOf(const BoxArea& a, const Vec3& point) {
  const Vec3 p = a.place.toLocal(point);
  const Vec3 beyond = p.cwiseAbs() - a.halfExtents;
  Vec3 n = beyond.cwiseMax(0.0);
  if (n.isZero()) {
    int axis;
    beyond.maxCoeff(&axis);
    n = Vec3::Unit(axis);
  }
  for (int i = 0; i < 3; ++i)
    if (p[i] < 0) n[i] = -n[i];
  return a.place.orientation * unit(n);
}

Vec3 normalOf(const EllipsoidArea& a, const Vec3& point) {
  const Vec3 p = a.place.toLocal(point);
  return a.place.orientation * unit(p.cwiseQuotient(a.semiAxes.cwiseProduct(a.semiAxes)));
}

Vec3 normalOf(const CloudArea& a, const Vec3& point) {
  const Vec3 p = a.place.toLocal(point);
  const double half = 0.5 * a.cloud->voxelSize();
  Vec3 n;
  for (int i = 0; i < 3; ++i)
    n[i] = depthAt(*a.cloud, *a.depth, p - half * Vec3::Unit(i)) -
           depthAt(*a.cloud, *a.depth, p + half * Vec3::Unit(i));
  return a.place.orientation * unit(n);
}

CloudArea cloudArea(const Cloud& cloud, const Pose& place) {
  if (cloud.empty()) throw std::invalid_argument("cloudArea: the cloud is empty");
  return {std::make_shared<const Cloud>(cloud), place,
          std::make_shared<const std::vector<float>>(cloudDepth(cloud)), matterOf(cloud)};
}

Cloud surfaceLayer(const Cloud& tool, double thickness, const Area* where) {
  if (!(thickness > 0) || !std::isfinite(thickness))
    throw std::invalid_argument("surfaceLayer: the thickness must be positive and finite");
  if (tool.empty()) throw std::invalid_argument("surfaceLayer: the tool is empty");
  const std::vector<float> depth = cloudDepth(tool);
  auto layer = std::make_shared<Cloud::Voxels>();
  layer->bricks = tool.bricks();
  layer->table.assign(tool.voxels().table.size(), kEmptyBrick);
  std::size_t voxel = 0;
  const double h = tool.voxelSize();
  forEachVoxel(tool.size(), [&](int x, int y, int z) {
    const double below = static_cast<double>(depth[voxel++]);
    // How much of the voxel lies above the layer's floor, and how much of it in `where`.
    double share = std::clamp((thickness - below) / h + 0.5, 0.0, 1.0);
    if (where) share *= std::clamp(areaDepth(*where, tool.center(x, y, z)) / h + 0.5, 0.0, 1.0);
    const long kept = std::lround(share * tool.coverage(x, y, z));
    if (kept <= 0) return;
    const std::size_t entry =
        static_cast<std::size_t>(x >> 3) +
        static_cast<std::size_t>(layer->bricks.x()) *
            (static_cast<std::size_t>(y >> 3) +
             static_cast<std::size_t>(layer->bricks.y()) * static_cast<std::size_t>(z >> 3));
    if (layer->table[entry] < 0) {
      layer->table[entry] = static_cast<std::int32_t>(layer->coverage.size());
      layer->coverage.emplace_back();
      layer->coverage.back().fill(0);
    }
    layer->coverage[static_cast<std::size_t>(layer->table[entry])]
                   [static_cast<std::size_t>((x & 7) | (y & 7) << 3 | (z & 7) << 6)] =
        static_cast<std::uint8_t>(kept);
  });
  if (layer->coverage.empty())
    throw std::invalid_argument("surfaceLayer: no matter of the tool lies there");
  return Cloud(h, tool.origin(), std::move(layer));
}

void requireArea(const Area& area) {
  struct Check {
    void operator()(const SphereArea& a) const {
      requireSizes("a sphere area's radius", Vec3::Constant(a.radius),
                   {Eigen::Quaterniond::Identity(), a.center});
    }
    void operator()(const BoxArea& a) const {
      requireSizes("a box area's half extents", a.halfExtents, a.place);
    }
    void operator()(const EllipsoidArea& a) const {
      requireSizes("an ellipsoid area's semi-axes", a.semiAxes, a.place);
    }
    void operator()(const CloudArea& a) const {
      if (!a.cloud || !a.depth)
        throw std::invalid_argument("a cloud area has no cloud: make it with cloudArea()");
      requireSizes("a cloud area's voxel", Vec3::Constant(a.cloud->voxelSize()), a.place);
    }
  };
  std::visit(Check{}, area);
}

double areaDepth(const Area& area, const Vec3& point) {
  return std::visit([&](const auto& a) { return depthOf(a, point); }, area);
}

Vec3 areaNormal(const Area& area, const Vec3& point) {
  return std::visit([&](const auto& a) { return normalOf(a, point); }, area);
}

Eigen::AlignedBox3d areaBounds(const Area& area) {
  return std::visit(Bounds{}, area);
}

Vec3 centerOfGravity(const Area& area) {
  struct Center {
    Vec3 operator()(const SphereArea& a) const { return a.center; }
    Vec3 operator()(const BoxArea& a) const { return a.place.position; }
    Vec3 operator()(const EllipsoidArea& a) const { return a.place.position; }
    Vec3 operator()(const CloudArea& a) const {
      return a.place.toWorld(a.cloud->massProperties().centerOfMass);
    }
  };
  return std::visit(Center{}, area);
}

Vec3 centerOfBounds(const Area& area) {
  return areaBounds(area).center();
}

}  // namespace cloudcontact
