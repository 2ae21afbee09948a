// Levels are built under a flag each, so that two threads may build two of them.
#include <cloudcontact/field/field_levels.h>
#include <cloudcontact/voxels/coarser_cloud.h>

#include <atomic>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <utility>
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

}  // namespace

struct FieldLevels::State {
  struct Level {
    std::once_flag building, measuring;
    std::shared_ptr<const SurfaceField> field;
    LevelError error;
    std::atomic<bool> isBuilt = false;
  };

  Cloud cloud;
  Eigen::AlignedBox3d bounds;
  FieldSettings settings;
  Make make;
  std::shared_ptr<const FieldLevels> of;  // or null
  double factor = 1;                      // of `of`
  std::vector<Level> levels;

  State(const Cloud& finest, const FieldSettings& how, Make makes)
      : cloud(finest),
        bounds(boundsOf(finest)),
        settings(how),
        make(makes ? std::move(makes) : SurfaceField::build),
        levels(static_cast<std::size_t>(countOf(bounds, cloud.voxelSize()))) {}

  Level& at(int level) { return levels.at(static_cast<std::size_t>(level)); }
  const std::shared_ptr<const SurfaceField>& field(int level) {
    Level& one = at(level);
    std::call_once(one.building, [&] {
      one.field = build(level);
      one.isBuilt = true;
    });
    return one.field;
  }
  const LevelError& error(int level) {
    Level& one = at(level);
    std::call_once(one.measuring, [&] {
      if (level == 0) return;
      const auto& made = field(level);
      one.error = made ? LevelError(*made, cloud) : LevelError::unseen();
    });
    return one.error;
  }
  // Null if no voxel is half full.
  std::shared_ptr<const SurfaceField> build(int level) {
    if (of) {
      const auto& field = of->field(level);
      return field ? scaled(*field, factor) : nullptr;
    }
    if (level == 0) return make(cloud, settings);
    FieldSettings how = settings;
    how.renewable = false;
    how.edgeSearches.reset();
    try {
      return make(coarserCloud(cloud, level), how);
    } catch (const std::invalid_argument&) {
      return nullptr;
    }
  }
};

FieldLevels::FieldLevels(const Cloud& finest, const FieldSettings& settings, Make make)
    : state_(std::make_unique<State>(finest, settings, std::move(make))) {}

FieldLevels::FieldLevels(std::shared_ptr<const SurfaceField> finest, const FieldSettings& settings)
    : state_(std::make_unique<State>(finest ? finest->cloud() : Cloud(), settings, Make())) {
  State::Level& own = state_->at(0);
  std::call_once(own.building, [&] { own.field = std::move(finest), own.isBuilt = true; });
}

FieldLevels::FieldLevels(std::shared_ptr<const FieldLevels> of, double factor)
    : state_(std::make_unique<State>(of ? of->cloud().scaled(factor) : Cloud(),
                                     of ? of->state_->settings : FieldSettings(), Make())) {
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
  return state_->field(level);
}
bool FieldLevels::isBuilt(int level) const {
  return state_->levels.at(static_cast<std::size_t>(level)).isBuilt;
}

double FieldLevels::error(int level) const {
  if (state_->of) return state_->factor * state_->of->error(level);
  return state_->error(level).most();
}

double FieldLevels::error(int level, const Eigen::AlignedBox3d& region) const {
  const double factor = state_->factor;
  if (state_->of)
    return factor * state_->of->error(level, {region.min() / factor, region.max() / factor});
  return state_->error(level).in(region);
}

int FieldLevels::coarsest(double tolerance) const {
  int level = count() - 1;
  while (level > 0 && !(error(level) <= tolerance)) --level;
  return level;
}

std::size_t FieldLevels::bytes() const {
  std::size_t sum = state_->cloud.bytes();
  for (int level = 0; level < count(); ++level) {
    const State::Level& one = state_->at(level);
    sum += one.error.bytes();
    if (!one.isBuilt || !one.field) continue;
    sum += one.field->bytes();
    if (level > 0) sum += one.field->cloud().bytes();
  }
  return sum;
}

}  // namespace cloudcontact
