// SurfaceField: built from a cloud in four steps (field_builder.h), then read.
#include "field_data.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace cloudcontact {

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
    : cloud_(std::move(cloud)), band_(std::move(band)) {
  for (const SurfaceSample& s : samples)
    bounds_.extend(cloud_.origin() +
                   cloud_.voxelSize() * Vec3(s.position[0], s.position[1], s.position[2]));
  samples_ = sortSamples(std::move(samples));
  measureDistance();
  markNear();
}

// Two sweeps of a Chebyshev distance transform over the table of bricks.
void FieldData::measureDistance() {
  const Eigen::Vector3i n = band_.grid.bricks();
  const auto index = [&](int x, int y, int z) {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(n.x()) *
               (static_cast<std::size_t>(y) +
                static_cast<std::size_t>(n.y()) * static_cast<std::size_t>(z));
  };
  distance_.assign(band_.grid.table().size(), 255);
  for (std::size_t i = 0; i < distance_.size(); ++i)
    if (band_.grid.table()[i] >= 0) distance_[i] = 0;
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
          line[static_cast<std::size_t>(k)] = distance_[index(at.x(), at.y(), at.z())];
        }
        for (int k = 0; k < n[axis]; ++k) {
          int best = 255;
          for (int r = 0; r < best && r < n[axis]; ++r)
            for (int side : {-r, r})
              if (k + side >= 0 && k + side < n[axis])
                best = std::min(
                    best, std::max(r, static_cast<int>(line[static_cast<std::size_t>(k + side)])));
          at[axis] = k;
          distance_[index(at.x(), at.y(), at.z())] = static_cast<std::uint8_t>(best);
        }
      }
  }
}

// Blocks that hold band voxels, and their 26 neighbours.
void FieldData::markNear() {
  const Eigen::Vector3i n = band_.grid.bricks();
  const auto index = [&](int x, int y, int z) { return band_.grid.tableIndex(x, y, z); };
  near_.assign(band_.grid.table().size(), 0);
  for (std::size_t t = 0; t < near_.size(); ++t) {
    if (band_.grid.table()[t] < 0) continue;
    const int b = static_cast<int>(t);
    const Eigen::Vector3i brick(b % n.x(), b / n.x() % n.y(), b / n.x() / n.y());
    std::uint8_t held = 0;
    const auto& cells = band_.grid.cells()[static_cast<std::size_t>(band_.grid.table()[t])];
    for (int k = 0; k < kBrickVoxels; ++k)
      if (ccPlaneCount(cells[static_cast<std::size_t>(k)]) > 0)
        held |= static_cast<std::uint8_t>(1 << ((k >> 2 & 1) | (k >> 4 & 2) | (k >> 6 & 4)));
    for (int block = 0; block < 8; ++block) {
      if (!(held >> block & 1)) continue;
      for (int k = 0; k < 27; ++k) {
        const int x = brick.x() * 8 + (block & 1) * 4 + (k % 3 - 1) * 4,
                  y = brick.y() * 8 + (block >> 1 & 1) * 4 + (k / 3 % 3 - 1) * 4,
                  z = brick.z() * 8 + (block >> 2) * 4 + (k / 9 - 1) * 4;
        if (!band_.grid.contains(x, y, z)) continue;
        near_[index(x, y, z)] |=
            static_cast<std::uint8_t>(1 << ((x >> 2 & 1) | (y >> 1 & 2) | (z & 4)));
      }
    }
  }
}

std::size_t FieldData::bytes() const {
  return band_.grid.cells().size() * sizeof(band_.grid.cells()[0]) +
         band_.grid.table().size() * (sizeof(std::int32_t) + 1) +
         band_.planes.size() * sizeof(CcVoxel) + samples_.bytes();
}

std::optional<FieldPoint> FieldData::at(const Vec3& local) const {
  const Vec3 g = (local - cloud_.origin()) / cloud_.voxelSize();
  if (!(g.array().abs() < 32767.0).all()) return std::nullopt;
  const Eigen::Vector3i v = g.array().floor().cast<int>();
  const CcVoxel record = band_.grid.at(v.x(), v.y(), v.z());
  if (ccPlaneCount(record) == 0) return std::nullopt;
  const Vec3 r = g - v.cast<double>() - Vec3::Constant(0.5);
  const float x[3] = {float(r.x()), float(r.y()), float(r.z())};
  const CcDepth d = ccVoxelDepth(record, band_.planes.data(), x);
  return FieldPoint{d.depth * cloud_.voxelSize(), Vec3(d.normal[0], d.normal[1], d.normal[2])};
}

}  // namespace cloudcontact
