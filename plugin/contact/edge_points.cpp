// Goes over the voxels in the box that hold several planes. Two planes meet in a line: its point
// nearest to the voxel's middle counts. Three meet in a corner. A point counts if it lies in or
// beside its voxel and behind the voxel's other planes.
#include "contact/edge_points.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include <cloudcontact/voxels/voxel_cut.h>

#include "field/field_data.h"

namespace cloudcontact {

namespace {

constexpr double kBeside = 0.6;       // [voxels] from the voxel's middle, along each axis
constexpr double kBehind = 0.05;      // [voxels] that a point may lie before another plane
constexpr double kParallel = 0.98;    // planes closer than 11 deg have no sharp edge
constexpr double kLeastCorner = 0.3;  // volume of three normals

struct Planes {
  int count = 0;
  Vec3 normal[CC_MAX_PLANES];
  double offset[CC_MAX_PLANES] = {};
};

Planes planesOf(const FieldData& data, CcVoxel record) {
  Planes planes;
  planes.count = static_cast<int>(ccPlaneCount(record));
  const float middle[3] = {0, 0, 0};
  for (int k = 0; k < planes.count; ++k) {
    const CcDepth d = ccPlaneDepth(data.planes()[record.b + static_cast<uint>(k)], middle);
    planes.normal[k] = {d.normal[0], d.normal[1], d.normal[2]};
    planes.offset[k] = static_cast<double>(d.depth);
  }
  return planes;
}

bool counts(const Planes& planes, const Vec3& x) {
  if (!(x.cwiseAbs().maxCoeff() <= kBeside)) return false;
  for (int k = 0; k < planes.count; ++k)
    if (planes.offset[k] - planes.normal[k].dot(x) < -kBehind) return false;
  return true;
}

// Calls visit(place from the voxel's middle) for each sharp point.
template <typename Visit>
void eachPoint(const Planes& p, const Visit& visit) {
  for (int i = 0; i < p.count; ++i)
    for (int j = i + 1; j < p.count; ++j) {
      const double c = p.normal[i].dot(p.normal[j]);
      if (c > kParallel) continue;
      const double per = 1 / (1 - c * c);
      const Vec3 x = per * ((p.offset[i] - c * p.offset[j]) * p.normal[i] +
                            (p.offset[j] - c * p.offset[i]) * p.normal[j]);
      if (counts(p, x)) visit(x);
      for (int k = j + 1; k < p.count; ++k) {
        Eigen::Matrix3d rows;
        rows << p.normal[i].transpose(), p.normal[j].transpose(), p.normal[k].transpose();
        if (std::abs(rows.determinant()) < kLeastCorner) continue;
        const Vec3 corner = rows.inverse() * Vec3(p.offset[i], p.offset[j], p.offset[k]);
        if (counts(p, corner)) visit(corner);
      }
    }
}

// Whether most neighbors that know corners have the point behind all their planes. The line of two
// planes goes on past a corner, and one voxel in a hundred beside a corner has a wrong face.
bool confirmed(const FieldData& data, const VoxelIndex& v, const Vec3& place) {
  int yes = 0, no = 0;
  for (int k = 0; k < 27; ++k) {
    const Eigen::Vector3i aside(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1), at = v + aside;
    const CcVoxel record = data.records().at(at.x(), at.y(), at.z());
    if (ccPlaneCount(record) < 3 || ccConcave(record)) continue;
    const Vec3 x = place - aside.cast<double>();
    const float point[3] = {float(x.x()), float(x.y()), float(x.z())};
    const bool behind =
        static_cast<double>(ccVoxelDepth(record, data.planes(), point).depth) > -2 * kBehind;
    behind ? ++yes : ++no;
  }
  return yes >= no;
}

}  // namespace

double deepestSharpPoint(const SurfaceField& sharp, const SurfaceField& other, const Pose& toOther,
                         const Eigen::AlignedBox3d& within) {
  const Cloud& cloud = sharp.cloud();
  const double h = cloud.voxelSize();
  const Vec3 most = cloud.size().cast<double>() - Vec3::Ones();
  const auto voxelOf = [&](const Vec3& x) -> Eigen::Vector3i {
    return ((x - cloud.origin()) / h).cwiseMax(0.0).cwiseMin(most).cast<int>();
  };
  const Eigen::Vector3i low = voxelOf(within.min()), high = voxelOf(within.max());
  double deepest = -std::numeric_limits<double>::infinity();
  for (int z = low.z(); z <= high.z(); ++z)
    for (int y = low.y(); y <= high.y(); ++y)
      for (int x = low.x(); x <= high.x(); ++x) {
        const CcVoxel record = sharp.data().records().at(x, y, z);
        if (ccPlaneCount(record) < 2 || ccConcave(record)) continue;
        eachPoint(planesOf(sharp.data(), record), [&](const Vec3& place) {
          const Vec3 at = cloud.center(x, y, z) + h * place;
          if (!confirmed(sharp.data(), {x, y, z}, place)) return;
          if (const auto found = other.at(toOther.toWorld(at)))
            deepest = std::max(deepest, found->depth);
        });
      }
  return deepest;
}

}  // namespace cloudcontact
