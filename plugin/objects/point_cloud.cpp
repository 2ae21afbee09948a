// Points from voxels, and voxels from points that fill a volume: see point_cloud.h. Points of a
// surface are in surface_points.cpp.
#include <cloudcontact/objects/point_cloud.h>

#include <cmath>
#include <stdexcept>

#include "voxels/cloud_builder.h"
#include "voxels/local_surface.h"

namespace cloudcontact {

using Eigen::Vector3i;

namespace {

[[noreturn]] void fail(const std::string& why) {
  throw std::invalid_argument("points: " + why);
}

void validatePerEdge(int perEdge) {
  if (perEdge < 1 || perEdge > 16) fail("perEdge must be from 1 to 16");
}

void addPoint(PointCloud& points, const Vec3& at, float share, std::uint8_t material) {
  points.positions.push_back(at);
  points.shares.push_back(share);
  if (!points.materials.empty()) points.material.push_back(material);
}

Vec3 partCenter(const Cloud& cloud, const Vector3i& voxel, std::size_t k, int n) {
  const int i = static_cast<int>(k);
  const Vec3 part(i % n + 0.5, i / n % n + 0.5, i / (n * n) + 0.5);
  return cloud.origin() + cloud.voxelSize() * (voxel.cast<double>() + part / n);
}

}  // namespace

void validate(const PointCloud& p) {
  const std::size_t n = p.positions.size();
  if (!(p.spacing >= 0) || !std::isfinite(p.spacing)) fail("spacing must be finite, not negative");
  if (!p.shares.empty() && p.shares.size() != n)
    fail("shares must be as many as positions, or none");
  if (!p.normals.empty() && p.normals.size() != n)
    fail("normals must be as many as positions, or none");
  if (!p.material.empty() && p.material.size() != n)
    fail("material must be as many as positions, or none");
  if (p.materials.size() > 256) fail("more than 256 materials");
  for (std::size_t i = 0; i < n; ++i)
    if (!p.positions[i].allFinite()) fail("position " + std::to_string(i) + " is NaN or infinite");
  for (const float s : p.shares)
    if (!(s >= 0 && s <= 1)) fail("a share is not from 0 to 1");
  for (const Eigen::Vector3f& normal : p.normals)
    if (!(std::abs(normal.norm() - 1) < 1e-3f)) fail("a normal is not of length 1");
  for (const std::uint8_t m : p.material)
    if (m > 0 && m >= p.materials.size()) fail("a point names no material");
}

PointCloud centerPoints(const Cloud& cloud, int perEdge) {
  validatePerEdge(perEdge);
  PointCloud points;
  points.spacing = cloud.voxelSize() / perEdge;
  points.materials = cloud.materials();
  std::vector<float> shares;
  forEachVoxel(cloud, [&](const Vector3i& voxel, int) {
    divideVoxel(cloud, voxel, perEdge, shares);
    const std::uint8_t material = cloud.material(voxel[0], voxel[1], voxel[2]);
    for (std::size_t k = 0; k < shares.size(); ++k)
      if (shares[k] > 0)
        addPoint(points, partCenter(cloud, voxel, k, perEdge), shares[k], material);
  });
  return points;
}

PointCloud cornerPoints(const Cloud& cloud) {
  PointCloud points;
  points.spacing = cloud.voxelSize();
  points.materials = cloud.materials();
  if (cloud.empty()) return points;
  // The cubes around the corners form a cloud that is shifted by half a voxel. It has one more
  // brick, for the outermost corners.
  const double h = cloud.voxelSize();
  CloudBuilder corners(
      {h, cloud.origin() - Vec3::Constant(0.5 * h), cloud.bricks() + Vector3i::Ones()},
      cloud.materials());
  std::vector<float> shares;
  forEachVoxel(cloud, [&](const Vector3i& voxel, int) {
    divideVoxel(cloud, voxel, 2, shares);
    const std::uint8_t material = cloud.material(voxel[0], voxel[1], voxel[2]);
    for (int k = 0; k < 8; ++k)
      corners.add(voxel + Vector3i(k & 1, k >> 1 & 1, k >> 2), shares[k] / 8, material);
  });
  const Cloud about = corners.build();
  forEachVoxel(about, [&](const Vector3i& corner, int coverage) {
    addPoint(points, cloud.origin() + h * corner.cast<double>(), static_cast<float>(coverage) / 255,
             about.material(corner[0], corner[1], corner[2]));
  });
  return points;
}

PointCloud surfacePoints(const Cloud& cloud, int perEdge, int threads) {
  validatePerEdge(perEdge);
  PointCloud points;
  points.materials = cloud.materials();
  for (const SurfacePlace& place : surfacePlaces(cloud, perEdge, threads)) {
    points.positions.push_back(place.position);
    points.normals.push_back(place.normal.cast<float>());
    if (!points.materials.empty()) points.material.push_back(place.material);
  }
  return points;
}

Cloud toCloud(const PointCloud& points, double voxelSize) {
  if (!points.fillsVolume()) {
    ScanSettings settings;
    settings.voxelSize = voxelSize;
    return toCloud(points, settings);
  }
  validate(points);
  Eigen::AlignedBox3d box;
  for (const Vec3& p : points.positions) box.extend(p);
  const Vec3 half = Vec3::Constant(0.5 * points.spacing);
  if (!points.positions.empty()) box.min() -= half, box.max() += half;
  CloudBuilder builder(cloudGrid("points", box, voxelSize, box.min()), points.materials);
  for (std::size_t i = 0; i < points.positions.size(); ++i)
    builder.addBox(points.positions[i] - half, points.positions[i] + half,
                   points.shares.empty() ? 1 : points.shares[i],
                   points.material.empty() ? std::uint8_t{0} : points.material[i]);
  return builder.build();
}

}  // namespace cloudcontact
