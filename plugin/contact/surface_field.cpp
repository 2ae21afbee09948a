// SurfaceField: built from a cloud in four steps (field_builder.h), then read.
#include "field_data.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace cloudcontact {

namespace {

// Two sweeps of a Chebyshev distance transform over the table of bricks.
std::vector<std::uint8_t> distanceToBand(const BrickGrid<CcVoxel>& grid) {
  const Eigen::Vector3i n = grid.bricks();
  const auto index = [&](int x, int y, int z) {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(n.x()) *
               (static_cast<std::size_t>(y) +
                static_cast<std::size_t>(n.y()) * static_cast<std::size_t>(z));
  };
  std::vector<std::uint8_t> distance(grid.table().size(), 255);
  for (std::size_t i = 0; i < distance.size(); ++i)
    if (grid.table()[i] >= 0) distance[i] = 0;
  for (int axis = 0; axis < 3; ++axis) {
    // Per axis: d(x) = min over y of max(d(y), |x - y|), by relaxing along the line both ways.
    std::vector<std::uint8_t> line(static_cast<std::size_t>(n[axis]));
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    for (int j = 0; j < n[b]; ++j)
      for (int i = 0; i < n[a]; ++i) {
        Eigen::Vector3i at;
        at[a] = i;
        at[b] = j;
        for (int k = 0; k < n[axis]; ++k) {
          at[axis] = k;
          line[static_cast<std::size_t>(k)] = distance[index(at.x(), at.y(), at.z())];
        }
        for (int k = 0; k < n[axis]; ++k) {
          int best = 255;
          for (int r = 0; r < best && r < n[axis]; ++r)
            for (int side : {-r, r})
              if (k + side >= 0 && k + side < n[axis])
                best = std::min(
                    best, std::max(r, static_cast<int>(line[static_cast<std::size_t>(k + side)])));
          at[axis] = k;
          distance[index(at.x(), at.y(), at.z())] = static_cast<std::uint8_t>(best);
        }
      }
  }
  return distance;
}

}  // namespace

std::shared_ptr<const SurfaceField> SurfaceField::build(const Cloud& cloud,
                                                        const FieldSettings& settings) {
  if (cloud.empty()) throw std::invalid_argument("SurfaceField::build: the cloud is empty");
  if ((cloud.size().array() > 32767).any())
    throw std::invalid_argument(
        "SurfaceField::build: more than 32767 voxels along an axis; take a larger voxel");
  FieldDraft draft{cloud, settings, {}, {}, BrickGrid<std::int32_t>(cloud.bricks(), -1)};
  const auto report = [&](double done) {
    if (settings.progress) settings.progress(done);
  };
  fitSurfaceVoxels(draft);
  if (draft.voxels.empty())
    throw std::invalid_argument("SurfaceField::build: the cloud has no surface");
  report(0.4);
  resolveEdges(draft);
  report(0.7);
  std::vector<SurfaceSample> samples = cutSamples(draft);
  report(0.8);
  Band band = spreadBand(draft);
  report(1.0);
  return std::make_shared<FieldData>(cloud, std::move(band), std::move(samples));
}

FieldData::FieldData(Cloud cloud, Band band, std::vector<SurfaceSample> samples)
    : cloud_(std::move(cloud)),
      bandVoxels_(band.voxels),
      planes_(std::move(band.planes)),
      distance_(distanceToBand(band.grid)),
      records_(cloud_, band, distance_) {
  for (const SurfaceSample& s : samples)
    bounds_.extend(cloud_.origin() +
                   cloud_.voxelSize() * Vec3(s.position[0], s.position[1], s.position[2]));
  samples_ = sortSamples(std::move(samples));
}

std::size_t FieldData::bytes() const {
  return records_.bytes() + distance_.size() + planes_.size() * sizeof(CcVoxel) + samples_.bytes();
}

std::optional<FieldPoint> FieldData::at(const Vec3& local) const {
  const Vec3 g = (local - cloud_.origin()) / cloud_.voxelSize();
  if (!(g.array().abs() < 32767.0).all()) return std::nullopt;
  const Eigen::Vector3i v = g.array().floor().cast<int>();
  const CcVoxel record = records_.at(v.x(), v.y(), v.z());
  if (ccPlaneCount(record) == 0) return std::nullopt;
  const Vec3 r = g - v.cast<double>() - Vec3::Constant(0.5);
  const float x[3] = {float(r.x()), float(r.y()), float(r.z())};
  const CcDepth d = ccVoxelDepth(record, planes_.data(), x);
  return FieldPoint{d.depth * cloud_.voxelSize(), Vec3(d.normal[0], d.normal[1], d.normal[2])};
}

}  // namespace cloudcontact
