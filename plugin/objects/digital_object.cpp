// Conversions and properties of all digital kinds: see digital_object.h.
#include <cloudcontact/objects/digital_object.h>
#include <cloudcontact/voxels/digitize.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "voxels/divided_voxels.h"

namespace cloudcontact {

namespace {

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;

Eigen::AlignedBox3d ofGrid(const Vec3& origin, double voxelSize, const Eigen::Vector3i& size) {
  Eigen::AlignedBox3d box(origin);
  box.extend(Vec3(origin + voxelSize * size.cast<double>()));
  return box;
}

Eigen::AlignedBox3d ofColumns(const ColumnCloud& c) {
  Eigen::AlignedBox3d box;
  if (c.intervals.empty()) return box;
  validate(c);
  const int u = (c.axis + 1) % 3, v = (c.axis + 2) % 3;
  for (std::size_t k = 0; k + 1 < c.first.size(); ++k)
    for (std::size_t i = c.first[k]; i < c.first[k + 1]; ++i) {
      const auto n = static_cast<std::size_t>(c.columns[0]);
      Vec3 low, high;
      low[u] = static_cast<double>(k % n) * c.width, high[u] = low[u] + c.width;
      low[v] = static_cast<double>(k / n) * c.width, high[v] = low[v] + c.width;
      low[c.axis] = c.intervals[i].low, high[c.axis] = c.intervals[i].high;
      box.extend(Vec3(c.origin + low));
      box.extend(Vec3(c.origin + high));
    }
  return box;
}

template <typename Balls>
Eigen::AlignedBox3d ofBalls(std::size_t count, const Balls& ball) {
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < count; ++i) {
    const auto [center, radius] = ball(i);
    box.extend(Vec3(center.array() - radius));
    box.extend(Vec3(center.array() + radius));
  }
  return box;
}

double hundredth(const DigitalObject& object) {
  const Eigen::AlignedBox3d box = boundsOf(object);
  if (box.isEmpty()) throw std::invalid_argument("toCloud: the object is empty");
  return suggestedVoxel(box);
}

}  // namespace

const char* kindName(const DigitalObject& object) {
  static constexpr const char* kNames[] = {"voxels", "points",      "spheres",    "columns",
                                           "octree", "sphere tree", "depth image"};
  static_assert(std::size(kNames) == std::variant_size_v<DigitalObject>);
  return kNames[object.index()];
}

Cloud resampled(const Cloud& cloud, double voxelSize) {
  if (!(voxelSize > 0) || !std::isfinite(voxelSize))
    throw std::invalid_argument("toCloud: voxelSize must be positive and finite [m]");
  if (cloud.empty() || voxelSize == cloud.voxelSize()) return cloud;
  return inVoxels("toCloud", cloud, Vec3::Constant(cloud.voxelSize()), cloud.origin(), voxelSize);
}

Cloud toCloud(const DigitalObject& object, double voxelSize) {
  if (boundsOf(object).isEmpty()) throw std::invalid_argument("toCloud: the object is empty");
  return std::visit(Overloaded{[&](const Cloud& o) { return resampled(o, voxelSize); },
                               [&](const Octree& o) { return resampled(o.cloud(), voxelSize); },
                               [&](const DepthImage& o) {
                                 DepthCloudSettings settings;
                                 settings.voxelSize = voxelSize;
                                 return toCloud(o, settings);
                               },
                               [&](const auto& o) { return toCloud(o, voxelSize); }},
                    object);
}

SphereCloud toSpheres(const SphereTree& tree) {
  SphereCloud spheres;
  spheres.materials = tree.materials();
  // A cube of edge 2 R / sqrt(3) has the volume of a sphere of radius 0.716 R.
  const double shrink = tree.kind() == SphereTree::Kind::Cubes
                            ? 2 / std::sqrt(3.0) * std::cbrt(0.75 / std::numbers::pi)
                            : 1;
  for (const SphereTree::Leaf& leaf : tree.leaves()) {
    spheres.centers.push_back(leaf.center);
    spheres.radii.push_back(shrink * leaf.radius);
    if (!spheres.materials.empty()) spheres.material.push_back(leaf.material);
  }
  return spheres;
}

PointCloud toPoints(const DepthImage& image) {
  validate(image);
  PointCloud points;
  for (const Vec3& p : image.points)
    if (p.allFinite()) points.positions.push_back(p);
  return points;
}

Eigen::AlignedBox3d boundsOf(const DigitalObject& object) {
  return std::visit(
      Overloaded{
          [](const Cloud& o) { return boundsOfVoxels(o); },
          [](const PointCloud& o) {
            validate(o);
            return ofBalls(o.positions.size(),
                           [&](std::size_t i) { return std::pair(o.positions[i], o.spacing / 2); });
          },
          [](const SphereCloud& o) {
            validate(o);
            return ofBalls(o.centers.size(),
                           [&](std::size_t i) { return std::pair(o.centers[i], o.radii[i]); });
          },
          [](const ColumnCloud& o) { return ofColumns(o); },
          [](const Octree& o) {
            Eigen::AlignedBox3d box;
            o.forEachIn(ofGrid(o.origin(), o.voxelSize(), o.size()), [&](const Octree::Cube& c) {
              const Vec3 low = o.origin() + o.voxelSize() * c.low.cast<double>();
              box.extend(low);
              box.extend(Vec3(low.array() + o.voxelSize() * c.edge));
            });
            return box;
          },
          [](const SphereTree& o) {
            const double part = o.kind() == SphereTree::Kind::Cubes ? 1 / std::sqrt(3.0) : 1;
            return ofBalls(o.leaves().size(), [&](std::size_t i) {
              return std::pair(o.leaves()[i].center, part * o.leaves()[i].radius);
            });
          },
          [](const DepthImage& o) {
            Eigen::AlignedBox3d box;
            for (const Vec3& p : o.points)
              if (p.allFinite()) box.extend(p);
            return box;
          }},
      object);
}

double suggestedVoxel(const DigitalObject& object) {
  return std::visit(Overloaded{[](const Cloud& o) { return o.voxelSize(); },
                               [](const Octree& o) { return o.voxelSize(); },
                               [](const ColumnCloud& o) { return 4 * o.width; },
                               [&](const PointCloud& o) {
                                 if (o.fillsVolume()) return o.spacing;
                                 return std::max(hundredth(object), 2 * pointDistance(o));
                               },
                               [&](const DepthImage& o) {
                                 return std::max(hundredth(object), 2 * pointDistance(toPoints(o)));
                               },
                               [&](const auto&) { return hundredth(object); }},
                    object);
}

}  // namespace cloudcontact
