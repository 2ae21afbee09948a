// Levels are built under a flag each, so that two threads may build two of them.
#include <cloudcontact/field/field_levels.h>
#include <cloudcontact/voxels/coarser_cloud.h>

#include <atomic>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <vector>

#include "base/grid_index.h"
#include "field/level_error.h"

namespace cloudcontact {

namespace {

constexpr int kThinnest = 6;    // [voxels] a body is at least this thick in its coarsest level
constexpr int kMostLevels = 8;  // voxels up to 128 times as large

Eigen::AlignedBox3d boundsOf(const Cloud& cloud) {
  if (cloud.empty()) throw std::invalid_argument("FieldLevels: the cloud is empty");
  Eigen::AlignedBox3i box;
  const Cloud::Voxels& voxels = cloud.voxels();
  for (std::size_t entry = 0; entry < voxels.table.size(); ++entry) {
    const std::int32_t b = voxels.table[entry];
    if (b == kEmptyBrick) continue;
    const Eigen::Vector3i first = kBrickEdge * gridCell(entry, voxels.bricks);
    const Eigen::AlignedBox3i whole(first, first + Eigen::Vector3i::Constant(kBrickEdge - 1));
    if (box.contains(whole)) continue;
    if (b == kSolidBrick) {
      box.extend(whole);
      continue;
    }
    for (int k = 0; k < kBrickVoxels; ++k)
      if (voxels.coverage[b][k] > 0) box.extend(first + cellOffset(k));
  }
  if (box.isEmpty()) throw std::invalid_argument("FieldLevels: the cloud is empty");
  const double h = cloud.voxelSize();
  return {cloud.origin() + h * box.min().cast<double>(),
          cloud.origin() + h * (box.max() + Eigen::Vector3i::Ones()).cast<double>()};
}

int countOf(const Eigen::AlignedBox3d& bounds, double voxel) {
  const double thickness = std::round(bounds.sizes().minCoeff() / voxel);
  int count = 1;
  while (count < kMostLevels && thickness >= kThinnest << count) ++count;
  return count;
}

struct Level {
  mutable std::once_flag once;
  std::shared_ptr<const SurfaceField> field;
  LevelError error;
  std::atomic<bool> isBuilt = false;
};

}  // namespace

struct FieldLevels::State {
  Cloud cloud;
  Eigen::AlignedBox3d bounds;
  FieldSettings settings;
  std::shared_ptr<const FieldLevels> of;  // or null
  double factor = 1;                      // of `of`
  std::vector<Level> levels;

  State(const Cloud& finest, const FieldSettings& how)
      : cloud(finest),
        bounds(boundsOf(finest)),
        settings(how),
        levels(static_cast<std::size_t>(countOf(bounds, cloud.voxelSize()))) {}

  Level& at(int level) {
    Level& one = levels.at(static_cast<std::size_t>(level));
    std::call_once(one.once, [&] {
      if (!one.field) build(level, one);
      one.isBuilt = true;
    });
    return one;
  }
  void build(int level, Level& one) {
    if (of) {
      const auto& field = of->field(level);
      one.field = field ? scaled(*field, factor) : nullptr;
    } else if (level == 0) {
      one.field = SurfaceField::build(cloud, settings);
    } else {
      FieldSettings how = settings;
      how.renewable = false;
      how.edgeSearches.reset();
      try {
        one.field = SurfaceField::build(coarserCloud(cloud, level), how);
        one.error = LevelError(*one.field, cloud);
      } catch (const std::invalid_argument&) {
        one.error = LevelError::unseen();  // too thin: no voxel is half full
      }
    }
  }
};

FieldLevels::FieldLevels(const Cloud& finest, const FieldSettings& settings)
    : state_(std::make_unique<State>(finest, settings)) {}

FieldLevels::FieldLevels(std::shared_ptr<const SurfaceField> finest, const FieldSettings& settings)
    : state_(std::make_unique<State>(finest ? finest->cloud() : Cloud(), settings)) {
  state_->levels[0].field = std::move(finest);
  state_->at(0);
}

FieldLevels::FieldLevels(std::shared_ptr<const FieldLevels> of, double factor)
    : state_(std::make_unique<State>(of ? of->cloud().scaled(factor) : Cloud(),
                                     of ? of->state_->settings : FieldSettings())) {
  state_->factor = factor;
  state_->of = std::move(of);
}

FieldLevels::~FieldLevels() = default;

int FieldLevels::count() const {
  return static_cast<int>(state_->levels.size());
}
const Cloud& FieldLevels::cloud() const {
  return state_->cloud;
}
double FieldLevels::voxelSize(int level) const {
  return std::ldexp(state_->cloud.voxelSize(), level);
}
const Eigen::AlignedBox3d& FieldLevels::bounds() const {
  return state_->bounds;
}
const std::shared_ptr<const SurfaceField>& FieldLevels::field(int level) const {
  return state_->at(level).field;
}
bool FieldLevels::isBuilt(int level) const {
  return state_->levels.at(static_cast<std::size_t>(level)).isBuilt;
}

double FieldLevels::error(int level) const {
  if (state_->of) return state_->factor * state_->of->error(level);
  return level == 0 ? 0 : state_->at(level).error.most();
}

double FieldLevels::error(int level, const Eigen::AlignedBox3d& region) const {
  const double factor = state_->factor;
  if (state_->of)
    return factor * state_->of->error(level, {region.min() / factor, region.max() / factor});
  return level == 0 ? 0 : state_->at(level).error.in(region);
}

int FieldLevels::coarsest(double tolerance) const {
  int level = count() - 1;
  while (level > 0 && !(error(level) <= tolerance)) --level;
  return level;
}

std::size_t FieldLevels::bytes() const {
  std::size_t sum = state_->cloud.bytes();
  for (int level = 0; level < count(); ++level) {
    if (!isBuilt(level)) continue;
    const Level& one = state_->levels[static_cast<std::size_t>(level)];
    sum += one.field->bytes() + one.error.bytes();
    if (level > 0) sum += one.field->cloud().bytes();
  }
  return sum;
}

}  // namespace cloudcontact
