// Each step is one upload, three kernels and one download: see opencl_workpiece.h.
#include "device/opencl_workpiece.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "base/grid_index.h"
#include "field/brick_layout.h"

namespace cloudcontact::opencl {

namespace {

using Bricks = BaseVectorField::Bricks;

constexpr std::size_t kMaxAtOnce = 1 << 20;  // voxels in a step; longer lists take several
constexpr std::size_t kGroups = 1 << 14;     // work-groups, which loop over the bricks
constexpr std::size_t kHead = CC_STEP_HEAD * sizeof(cl_uint);
static_assert(kHead % alignof(CcVoxelLeft) == 0, "voxels lie behind the head");

// An upper bound of the bricks whose windows see one voxel.
std::size_t maxBricks(const Window& window) {
  std::size_t product = 1;
  for (int k = 0; k < 3; ++k)
    product *= static_cast<std::size_t>(
        (std::max(window.high[k], 0) - std::min(window.low[k], 0) + 2 * kBrickEdge - 2) /
        kBrickEdge);
  return product + 1;
}

// Packs voxels for the device; returns whether all lie in the grid. One loop for both halves the
// time.
bool pack(std::span<const VoxelCut> voxels, const Eigen::Vector3i& size, CcVoxelLeft* to) {
  const Eigen::Matrix<unsigned, 3, 1> n = size.cast<unsigned>();
  unsigned outside = 0;
  for (const VoxelCut& c : voxels) {
    const auto x = static_cast<unsigned>(c.voxel.x()), y = static_cast<unsigned>(c.voxel.y()),
               z = static_cast<unsigned>(c.voxel.z());
    outside |= unsigned(x >= n.x()) | unsigned(y >= n.y()) | unsigned(z >= n.z());
    *to++ = {static_cast<cl_ushort>(x), static_cast<cl_ushort>(y), static_cast<cl_ushort>(z),
             c.coverage};
  }
  return outside == 0;
}

// The same on several cores for long lists.
bool packParallel(std::span<const VoxelCut> voxels, const Eigen::Vector3i& size, CcVoxelLeft* to) {
  constexpr std::size_t kPart = 1 << 13;
  std::atomic<bool> inside{true};
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, voxels.size(), kPart),
                    [&](const auto& part) {
                      if (!pack(voxels.subspan(part.begin(), part.size()), size, to + part.begin()))
                        inside = false;
                    });
  return inside;
}

// Adds a brick's sums, which are about its corner, to sums about the grid's center.
void addBrick(const CcTissueSums& brick, const VoxelIndex& corner, MatterSums& to) {
  const std::int64_t n = brick.sum[CC_SUM_1];
  to.mass += n;
  std::int64_t *const first = to.first.data(), *const second = to.second.data();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const std::int64_t x = corner[i], y = corner[j], byX = brick.sum[CC_SUM_X + i],
                       byY = brick.sum[CC_SUM_X + j];
    first[i] += n * x + byX;
    second[i] += n * x * x + 2 * x * byX + brick.sum[CC_SUM_XX + i];
    second[3 + i] += n * x * y + x * byY + y * byX + brick.sum[CC_SUM_XY + i];
  }
}

}  // namespace

// Why the field does not fit on the device; empty if it does.
std::string OpenClWorkpiece::lacking(const Bricks& field) const {
  if ((kBrickEdge * field.bricks).maxCoeff() > CC_WIDEST)
    return "its grid is wider than " + std::to_string(CC_WIDEST) + " voxels";
  const double blocks = static_cast<double>(blocks_) * sizeof(CcBlock);
  const double all = blocks + static_cast<double>(blocks_) * CC_BRICK_VOXELS * 6;
  const double margin = 1.25;  // that DeviceBuffer adds
  if (margin * blocks <= double(device_->largestBuffer()) &&
      margin * all <= 0.9 * double(device_->memory()))
    return {};
  return "it would take " + std::to_string(std::llround(1e-6 * margin * all)) +
         " MB on the device, most of them in one buffer";
}

// Reserves a block of its own for each brick with material. Bricks use it once they differ from the
// shared block.
void OpenClWorkpiece::assignHomes(const Bricks& field, std::size_t blocks) {
  table_.assign(field.table.begin(), field.table.end());
  homeOf_ = table_;
  shared_ = field.tissues.size();
  blocks_ = blocks;
  for (cl_int& home : homeOf_)
    if (home != kNoBlock && static_cast<std::size_t>(home) < shared_)
      home = static_cast<cl_int>(blocks_++);
  bricks_.assign(blocks_ - shared_, 0);
  for (std::size_t e = 0; e < homeOf_.size(); ++e)
    if (homeOf_[e] != kNoBlock)
      bricks_[static_cast<std::size_t>(homeOf_[e]) - shared_] = static_cast<cl_uint>(e);
}

void OpenClWorkpiece::sendWindow(const Bricks& field) {
  Device& d = *device_;
  const auto write = [&](DeviceBuffer& buffer, const auto& values) {
    buffer.fill(d, values, "field sent", true);
  };
  // Tissues of equal density are one kind.
  std::vector<cl_int> densities;
  std::vector<cl_uchar> kindOf;
  for (const int density : field.density) {
    const auto known = std::find(densities.begin(), densities.end(), density);
    kindOf.push_back(static_cast<cl_uchar>(known - densities.begin()));
    if (known == densities.end()) densities.push_back(density);
  }
  write(kindOf_, kindOf);
  write(densities_, densities);
  taps_.send(d, field.window, "field sent");
  write(home_, homeOf_);
  write(deviceTable_, table_);
  write(deviceBricks_, bricks_);
  grid_.kinds = static_cast<cl_int>(densities.size());
}

// Sends all but the blocks.
std::string OpenClWorkpiece::prepare(const Bricks& field, std::size_t blocks) {
  Device& d = *device_;
  assignHomes(field, blocks);
  if (const std::string why = lacking(field); !why.empty()) return why;
  const Window& w = field.window;
  grid_ = {field.bricks.x(),
           field.bricks.y(),
           field.bricks.z(),
           {w.low.x(), w.low.y(), w.low.z()},
           {w.high.x(), w.high.y(), w.high.z()},
           static_cast<cl_int>(w.taps.size()),
           0};
  maxBricks_ = maxBricks(w);
  sendWindow(field);
  deviceBlocks_.reserve(d, blocks_ * sizeof(CcBlock));
  last_.clear(d, blocks_ * CC_BRICK_VOXELS * sizeof(cl_uint));
  lost_.clear(d, blocks_ * CC_BRICK_VOXELS * sizeof(cl_ushort));
  listed_.clear(d, table_.size() * sizeof(cl_uint));
  list_.reserve(d, table_.size() * sizeof(cl_uint));
  lastVoxels_ = 0;
  return {};
}

std::string OpenClWorkpiece::load(const Bricks& field) {
  if (const std::string why = prepare(field, field.blocks.size()); !why.empty()) return why;
  device_->send(field.blocks.data(), deviceBlocks_.buffer(), field.blocks.size() * sizeof(CcBlock),
                "field sent", true);
  return {};
}

std::string OpenClWorkpiece::load(const Bricks& rest, const cl::Buffer& blocks, std::size_t count) {
  if (const std::string why = prepare(rest, count); !why.empty()) return why;
  device_->queue().enqueueCopyBuffer(blocks, deviceBlocks_.buffer(), 0, 0, count * sizeof(CcBlock),
                                     nullptr, device_->note("field copied"));
  device_->queue().finish();
  return {};
}

void OpenClWorkpiece::checkIntact() const {
  if (failed_)
    throw std::runtime_error(
        "DeviceWorkpiece: the device failed during an earlier cut, so its field is unknown; create "
        "the workpiece again");
}

// Does a cut. If it fails half-way, the workpiece stays failed.
template <typename Work>
void OpenClWorkpiece::change(Work&& work) {
  failed_ = true;
  settled(device_->queue(), work);
  failed_ = false;
}

// Links the voxels of the current step that are listed repeatedly, and clears the links of the last
// step.
void OpenClWorkpiece::linkVoxels(std::size_t voxels) {
  Device& d = *device_;
  const cl::Buffer &last = steps_[1 - current_].reserve(d, kHead),
                   &next = next_.reserve(d, std::max<std::size_t>(voxels, 1) * sizeof(cl_uint));
  d.run({"ccStringCuts", std::max(voxels, lastVoxels_), CC_STEP_GROUP}, grid_, home_.buffer(),
        deviceTable_.buffer(), deviceBlocks_.buffer(), steps_[current_].buffer(),
        static_cast<cl_uint>(voxels), last, static_cast<cl_uint>(lastVoxels_), next, last_.buffer(),
        lost_.buffer());
}

// Recomputes the windows of the listed bricks, of which there are at most `bricks`.
void OpenClWorkpiece::renewWindows(std::size_t bricks) {
  Device& d = *device_;
  const cl::Buffer &home = home_.buffer(), &table = deviceTable_.buffer(),
                   &blocks = deviceBlocks_.buffer(), &last = last_.buffer(), &lost = lost_.buffer(),
                   &listed = listed_.buffer(), &list = list_.buffer(),
                   &step = steps_[current_].buffer();
  const std::size_t items =
      std::min({blocks_ - shared_, bricks, kGroups}) * std::size_t{CC_RENEW_GROUP};
  if (taps_.flat()) {
    d.run({"ccRenewWindows", items, CC_RENEW_GROUP}, grid_, home, table, blocks, lost, last, listed,
          list, step, kindOf_.buffer(), densities_.buffer(), taps_.taps(), taps_.runs(),
          taps_.runCount(), cl::Local(static_cast<std::size_t>(grid_.taps) * sizeof(cl_float4)),
          cl::Local(taps_.runCount() * sizeof(CcFlatRun)), cl::Local(taps_.tileBytes()));
  } else {
    d.run({"ccRenewAnyWindows", items, CC_RENEW_GROUP}, grid_, home, table, blocks, lost, last,
          listed, list, step, kindOf_.buffer(), densities_.buffer(), taps_.taps());
  }
}

// Reads the counts of the current step and ends it.
void OpenClWorkpiece::readCounts() {
  auto* const counted = static_cast<cl_uint*>(fetched_.reserve(*device_, kHead));
  device_->fetch(steps_[current_].buffer(), counted, kHead, "counts fetched");
  report_.changed += counted[CC_CHANGED];
  report_.bricks += counted[CC_AFFECTED];
  report_.fetched += kHead;
  current_ = 1 - current_;
}

// Cuts packed voxels, which follow the head of the step.
void OpenClWorkpiece::runStep(const void* packed, std::size_t voxels) {
  Device& d = *device_;
  const std::size_t bytes = kHead + voxels * sizeof(CcVoxelLeft);
  const cl::Buffer& step = steps_[current_].reserve(d, bytes);
  d.send(packed, step, bytes, "step sent");
  linkVoxels(voxels);
  d.run({"ccNoteLosses", voxels, CC_STEP_GROUP}, grid_, home_.buffer(), deviceTable_.buffer(),
        deviceBlocks_.buffer(), step, static_cast<cl_uint>(voxels), next_.buffer(), last_.buffer(),
        lost_.buffer(), listed_.buffer(), list_.buffer());
  lastVoxels_ = voxels;
  renewWindows(voxels * maxBricks_);
  readCounts();
  report_.voxels += voxels;
  report_.sent += bytes;
}

// Cuts an area whose bounds cover so many bricks along each axis.
void OpenClWorkpiece::runStep(const CcArea& area, const std::size_t bricks[3], std::size_t count) {
  Device& d = *device_;
  const cl::Buffer& step = steps_[current_].reserve(d, kHead);
  d.queue().enqueueFillBuffer(step, cl_uint{0}, 0, kHead, nullptr, d.note("step sent"));
  if (lastVoxels_ > 0) linkVoxels(0);
  lastVoxels_ = 0;
  d.run({"ccNoteArea", count * CC_RENEW_GROUP, CC_RENEW_GROUP}, grid_, area,
        static_cast<cl_int>(bricks[0]), static_cast<cl_int>(bricks[1]), home_.buffer(),
        deviceTable_.buffer(), deviceBlocks_.buffer(), step, lost_.buffer(), listed_.buffer(),
        list_.buffer());
  renewWindows(kGroups);
  d.run({"ccForgetArea", std::min(blocks_ - shared_, kGroups) * CC_RENEW_GROUP, CC_RENEW_GROUP},
        home_.buffer(), list_.buffer(), step, lost_.buffer());
  readCounts();
}

std::size_t OpenClWorkpiece::cut(const CcArea& area) {
  checkIntact();
  report_ = {};
  std::size_t bricks[3], count = 1;
  for (int k = 0; k < 3; ++k) {
    if (area.low[k] > area.high[k]) return 0;
    bricks[k] = static_cast<std::size_t>((area.high[k] >> 3) - (area.low[k] >> 3) + 1);
    count *= bricks[k];
  }
  change([&] { runStep(area, bricks, count); });
  report_.sent = sizeof area;
  return report_.changed;
}

std::size_t OpenClWorkpiece::cut(std::span<const VoxelCut> voxels) {
  checkIntact();
  report_ = {};
  // All voxels are checked before the first is cut.
  const std::size_t step = kHead + kMaxAtOnce * sizeof(CcVoxelLeft);
  const std::size_t steps = (voxels.size() + kMaxAtOnce - 1) / kMaxAtOnce;
  auto* const packed = static_cast<unsigned char*>(
      sent_.reserve(*device_, steps * kHead + voxels.size() * sizeof(CcVoxelLeft)));
  const auto part = [&](std::size_t k) {
    return voxels.subspan(k * kMaxAtOnce)
        .first(std::min(kMaxAtOnce, voxels.size() - k * kMaxAtOnce));
  };
  const Eigen::Vector3i size = kBrickEdge * Eigen::Vector3i(grid_.nx, grid_.ny, grid_.nz);
  for (std::size_t k = 0; k < steps; ++k) {
    std::memset(packed + k * step, 0, kHead);
    if (!packParallel(part(k), size, reinterpret_cast<CcVoxelLeft*>(packed + k * step + kHead)))
      throw std::out_of_range("DeviceWorkpiece::cut: a voxel lies outside the grid");
  }
  change([&] {
    for (std::size_t k = 0; k < steps; ++k) runStep(packed + k * step, part(k).size());
  });
  return report_.changed;
}

std::vector<CcNormalSum> OpenClWorkpiece::normals(const TouchedList& list) {
  checkIntact();
  Device& d = *device_;
  std::vector<CcNormalSum> sums(list.firsts.size() - 1);
  settled(d.queue(), [&] {
    const cl::Buffer &voxels = touched_.fill(d, list.voxels, "areas sent"),
                     &firsts = firsts_.fill(d, list.firsts, "areas sent"),
                     &terms = terms_.fill(d, list.terms, "areas sent"),
                     &normals = normals_.reserve(d, sums.size() * sizeof(CcNormalSum));
    d.run({"ccDigitalNormals", sums.size() * CC_NORMAL_LANES, CC_NORMAL_LANES}, grid_.nx, grid_.ny,
          grid_.nz, deviceTable_.buffer(), deviceBlocks_.buffer(), terms, voxels, firsts, normals);
    d.fetch(normals, sums.data(), sums.size() * sizeof(CcNormalSum), "normals fetched");
  });
  return sums;
}

std::vector<MatterSums> OpenClWorkpiece::tissueSums() {
  checkIntact();
  Device& d = *device_;
  const std::size_t count = bricks_.size(), bytes = count * shared_ * sizeof(CcTissueSums);
  std::vector<MatterSums> all(shared_);
  if (count == 0) return all;
  d.run({"ccSumTissues", std::min(count, kGroups) * CC_ROWS, CC_ROWS}, deviceTable_.buffer(),
        deviceBlocks_.buffer(), deviceBricks_.buffer(), static_cast<cl_uint>(count),
        static_cast<cl_uint>(shared_), sums_.reserve(d, bytes));
  auto* const sums = static_cast<CcTissueSums*>(fetchedSums_.reserve(d, bytes));
  d.fetch(sums_.buffer(), sums, bytes, "sums fetched");
  const Eigen::Vector3i bricks(grid_.nx, grid_.ny, grid_.nz);
  for (std::size_t n = 0; n < count; ++n) {
    const VoxelIndex corner = kBrickEdge * gridCell(bricks_[n], bricks) - kBrickEdge / 2 * bricks;
    for (std::size_t t = 0; t < shared_; ++t) addBrick(sums[n * shared_ + t], corner, all[t]);
  }
  return all;
}

void OpenClWorkpiece::fetch(Bricks& to) {
  checkIntact();
  Device& d = *device_;
  d.fetch(deviceTable_.buffer(), table_.data(), table_.size() * sizeof(cl_int), "field fetched");
  // Own blocks in use, by their index: first those that the field came with, then in the order of
  // the table.
  std::vector<std::pair<cl_int, std::size_t>> used;
  for (std::size_t e = 0; e < table_.size(); ++e)
    if (table_[e] >= static_cast<cl_int>(shared_)) used.emplace_back(table_[e], e);
  std::sort(used.begin(), used.end());
  to.table.assign(table_.begin(), table_.end());
  to.blocks.resize(shared_ + used.size());
  const auto read = [&](std::size_t from, std::size_t first, std::size_t count) {
    d.queue().enqueueReadBuffer(deviceBlocks_.buffer(), CL_FALSE, from * sizeof(CcBlock),
                                count * sizeof(CcBlock), to.blocks.data() + first, nullptr,
                                d.note("field fetched"));
  };
  settled(d.queue(), [&] {
    read(0, 0, shared_);
    for (std::size_t k = 0, end = 0; k < used.size(); k = end) {
      for (end = k; end < used.size() && used[end].first - used[k].first == cl_int(end - k); ++end)
        to.table[used[end].second] = static_cast<std::int32_t>(shared_ + end);
      read(static_cast<std::size_t>(used[k].first), shared_ + k, end - k);
    }
    d.queue().finish();
  });
}

std::size_t OpenClWorkpiece::bytes() const {
  std::size_t sum = 0;
  for (const DeviceBuffer* g :
       {&steps_[0], &steps_[1], &next_, &last_, &lost_, &home_, &deviceTable_, &deviceBlocks_,
        &listed_, &list_, &kindOf_, &densities_, &deviceBricks_, &sums_, &touched_, &firsts_,
        &terms_, &normals_})
    sum += g->bytes();
  for (const DeviceBuffer* g : taps_.buffers()) sum += g->bytes();
  return sum;
}

}  // namespace cloudcontact::opencl
