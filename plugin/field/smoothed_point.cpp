// A trilinear mean of the planes around a point.
#include "field/smoothed_point.h"

#include "field/field_data.h"

#include <cmath>

namespace cloudcontact {

namespace {

constexpr double kOneSmoothFace = 0.9;  // cosine: normals that differ by more are of two faces
constexpr double kOneWall = 0.5;        // [voxels] depths that differ by more are, too

}  // namespace

SmoothedPoint smoothedPoint(const SurfaceField& field, const Vec3& local, const FieldPoint& own) {
  const FieldData& data = field.data();
  const double voxel = data.cloud().voxelSize();
  const Vec3 grid = (local - data.cloud().origin()) / voxel;
  const Eigen::Vector3i low = (grid.array() - 0.5).floor().cast<int>();
  Vec3 normal = Vec3::Zero();
  double depth = 0, sum = 0;
  bool oneFace = true;
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3i v = low + Eigen::Vector3i(k & 1, k >> 1 & 1, k >> 2);
    const CcVoxel record = data.records().at(v.x(), v.y(), v.z());
    if (ccPlaneCount(record) == 0) continue;
    oneFace = oneFace && ccPlaneCount(record) == 1;
    const Vec3 from = grid - v.cast<double>() - Vec3::Constant(0.5);
    const float x[3] = {float(from.x()), float(from.y()), float(from.z())};
    const CcDepth d = ccVoxelDepth(record, data.planes(), x);
    const Vec3 facing(d.normal[0], d.normal[1], d.normal[2]);
    if (facing.dot(own.normal) < kOneSmoothFace ||
        std::abs(d.depth - own.depth / voxel) > kOneWall) {
      oneFace = false;
      continue;
    }
    const double weight = (1 - from.cwiseAbs().array()).prod();
    normal += weight * facing;
    depth += weight * d.depth;
    sum += weight;
  }
  if (!(sum > 0)) return {own, false};
  return {{depth / sum * voxel, normal.normalized()}, oneFace};
}

}  // namespace cloudcontact
