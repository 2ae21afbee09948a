// One upload, one chain of kernels, then a look at its counters. If a buffer was too small, the
// chain runs again with buffers of the counted size.
#include "device/opencl_digitizer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <span>

namespace cloudcontact::opencl {

namespace {

using Bricks = BaseVectorField::Bricks;

constexpr std::size_t kMostGroups = 1 << 15;     // work-groups, which loop over the bricks
constexpr std::size_t kMaxPlaces = 0xffffffffu;  // that 32 bits can count
constexpr double kMaxUnits = double(kMaxPlaces) / CC_PIECE_UNIT - 1;
constexpr double kMaxListed = 1e9;
// First guess of places for pieces per listed triangle. An M16 bolt at 512 voxels needs 40.
constexpr std::size_t kPieces = 64;
constexpr int kMaxRounds = 6;

std::size_t bounded(double size, double most) {
  return static_cast<std::size_t>(std::clamp(size, 64.0, most));
}

std::string megabytes(double bytes) {
  return std::to_string(std::llround(bytes / 1e6)) + " MB";
}

// An upper bound of the list's length: each triangle in all columns of its bounding box.
double maxListed(const GridSurface& surface, const Frame& frame) {
  double sum = 0;
  for (const Eigen::Vector3i& t : surface.triangles) {
    const Vec3 &a = surface.vertices[static_cast<std::size_t>(t[0])],
               &b = surface.vertices[static_cast<std::size_t>(t[1])],
               &c = surface.vertices[static_cast<std::size_t>(t[2])];
    const auto bricks = [&](int axis) {
      const auto [low, high] = std::minmax({a[axis], b[axis], c[axis]});
      return std::floor((high + 1e-3) / kBrickEdge) - std::floor((low - 1e-3) / kBrickEdge) + 1;
    };
    sum += bricks(frame.u) * bricks(frame.v);
  }
  return sum;
}

}  // namespace

void OpenClDigitizer::guess(const GridSurface& surface, int axis, bool field) {
  guessRooms(surface, axis);
  if (!field) return;
  const std::size_t blocks =
      std::max<std::size_t>(windows_.blockRoom, 2 * std::size_t{grid_.brickRoom} + 1);
  windows_.blockRoom = static_cast<cl_uint>(std::min(blocks, maxBlocks()));
}

// One for each brick, and the shared one.
std::size_t OpenClDigitizer::maxBlocks() const {
  return std::min(table_ + 1, kMaxPlaces);
}

void OpenClDigitizer::guessRooms(const GridSurface& surface, int axis) {
  const Frame frame(surface, axis);
  const CcColumns before = grid_;
  grid_ = {frame.u,
           frame.v,
           frame.w,
           frame.width,
           frame.depth,
           frame.layers,
           surface.bricks[0],
           surface.bricks[1],
           static_cast<cl_uint>(surface.triangles.size()),
           !surface.component.empty(),
           before.entryRoom,
           before.pieceRoom,
           before.sumRoom,
           before.brickRoom};
  const bool sameSize = grid_.triangles == before.triangles && grid_.width == before.width &&
                        grid_.depth == before.depth && grid_.layers == before.layers;
  if (sameSize) return;
  columns_ = static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.depth);
  table_ = columns_ * static_cast<std::size_t>(frame.layers);
  constexpr double kFirstListed = 4e6;
  const double listed = std::min(maxListed(surface, frame), kFirstListed),
               all = static_cast<double>(table_ + columns_);
  const auto raise = [](cl_uint& room, std::size_t size) {
    room = std::max(room, static_cast<cl_uint>(std::min(size, kMaxPlaces)));
  };
  raise(grid_.entryRoom, bounded(listed, 1e9));
  raise(grid_.pieceRoom, bounded(kPieces * listed / CC_PIECE_UNIT, kMaxUnits));
  raise(grid_.sumRoom, bounded(listed / 2, all));
  raise(grid_.brickRoom, bounded(listed / 2, all));
}

// Why the buffers do not fit in device memory; empty if they do.
std::string OpenClDigitizer::lacking(bool field) const {
  const double needs[] = {
      double(grid_.entryRoom) * CC_COLUMNS * sizeof(CcColumnPieces),
      double(grid_.pieceRoom) * CC_PIECE_UNIT * 2 * sizeof(double),
      double(grid_.sumRoom) * CC_BRICK_VOXELS * sizeof(double),
      double(grid_.brickRoom) * CC_BRICK_VOXELS,
      double(columns_) * (grid_.layers + 1) * sizeof(cl_int),
      field ? double(windows_.blockRoom) * sizeof(CcBlock) : 0.0,
  };
  double sum = 0, most = 0;
  for (const double n : needs) sum += n, most = std::max(most, n);
  const double margin = 1.25;  // that DeviceBuffer adds
  if (margin * most <= double(device_->largestBuffer()) &&
      margin * sum <= 0.9 * double(device_->memory()))
    return {};
  return "it would take " + megabytes(margin * sum) + " on the device, " +
         megabytes(margin * most) + " of them in one buffer";
}

// Enlarges the sizes to what the chain counted; returns whether any was too small.
bool OpenClDigitizer::enlarge(bool field) {
  bool more = false;
  const auto enough = [&](cl_uint& room, int counter, cl_uint extra = 0,
                          std::size_t most = kMaxPlaces) {
    const std::size_t needed = std::size_t{counters_[std::size_t(counter)]} + extra;
    if (needed <= room) return;
    room = static_cast<cl_uint>(std::min(needed + needed / 8, most));
    more = true;
  };
  enough(grid_.entryRoom, CC_ENTRIES);
  enough(grid_.pieceRoom, CC_PIECES);
  grid_.pieceRoom = static_cast<cl_uint>(std::min<double>(grid_.pieceRoom, kMaxUnits));
  enough(grid_.sumRoom, CC_SUM_BRICKS);
  enough(grid_.brickRoom, CC_STORED);
  if (field) enough(windows_.blockRoom, CC_OWN_BLOCKS, 1, maxBlocks());
  return more;
}

void OpenClDigitizer::send(const GridSurface& surface) {
  Device& d = *device_;
  const std::size_t n = surface.vertices.size(), t = surface.triangles.size();
  const std::size_t vertices = n * 3 * sizeof(double), triangles = t * 3 * sizeof(cl_int),
                    shells = surface.component.size() * sizeof(cl_int);
  auto* const to = static_cast<unsigned char*>(sent_.reserve(d, vertices + triangles + shells));
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double) &&
                sizeof(Eigen::Vector3i) == 3 * sizeof(cl_int));
  std::memcpy(to, surface.vertices.data(), vertices);
  std::memcpy(to + vertices, surface.triangles.data(), triangles);
  std::vector<cl_int> component(surface.component.begin(), surface.component.end());
  if (shells > 0) std::fill(component.begin() + surface.firstCap, component.end(), -1);
  std::memcpy(to + vertices + triangles, component.data(), shells);
  const auto write = [&](DeviceBuffer& buffer, std::size_t begin, std::size_t size) {
    buffer.fill(d, std::span(to + begin, size), "mesh sent");
  };
  write(surface_, 0, vertices);
  write(triangles_, vertices, triangles);
  write(shells_, vertices + triangles, shells);
  d.queue().flush();
  report_.sent += vertices + triangles + shells;
}

void OpenClDigitizer::reserve() {
  Device& d = *device_;
  deviceCounters_.clear(d, CC_CUT_COUNTERS * sizeof(cl_uint));
  counts_.clear(d, columns_ * sizeof(cl_uint));
  touched_.clear(d, columns_ * static_cast<std::size_t>(grid_.layers + 1) * sizeof(cl_int));
  first_.reserve(d, (columns_ + 1) * sizeof(cl_uint));
  entries_.reserve(d, grid_.entryRoom * sizeof(cl_uint));
  owners_.reserve(d, grid_.entryRoom * sizeof(cl_uint));
  found_.reserve(d, std::size_t{grid_.entryRoom} * CC_COLUMNS * sizeof(CcColumnPieces));
  pieces_.reserve(d, std::size_t{grid_.pieceRoom} * CC_PIECE_UNIT * 2 * sizeof(double));
  placed_.reserve(d, grid_.sumRoom * sizeof(cl_uint));
  sums_.reserve(d, std::size_t{grid_.sumRoom} * CC_BRICK_VOXELS * sizeof(double));
  deviceTable_.reserve(d, table_ * sizeof(cl_int));
  stored_.reserve(d, columns_ * sizeof(cl_uint));
  firstStored_.reserve(d, (columns_ + 1) * sizeof(cl_uint));
  bricks_.reserve(d, std::size_t{grid_.brickRoom} * CC_BRICK_VOXELS);
}

void OpenClDigitizer::cut() {
  Device& d = *device_;
  constexpr std::size_t kRowItems = 8;  // CC_ROW_ITEMS
  const std::size_t items = kRowItems * grid_.triangles;
  const cl::Buffer &vertices = surface_.buffer(), &triangles = triangles_.buffer(),
                   &counters = deviceCounters_.buffer(), &counts = counts_.buffer(),
                   &first = first_.buffer(), &entries = entries_.buffer();
  d.run({"ccCountColumns", items, CC_GROUP}, grid_, vertices, triangles, counts);
  d.run({"ccScan", CC_SCAN_GROUP, CC_SCAN_GROUP}, counts, static_cast<cl_uint>(columns_), first,
        counters, cl_uint{CC_ENTRIES});
  counts_.clear(d, columns_ * sizeof(cl_uint));
  d.run({"ccListColumns", items, CC_GROUP}, grid_, vertices, triangles, counts, first, counters,
        entries, owners_.buffer());
  d.run({"ccSortColumns", columns_ * CC_GROUP, CC_GROUP}, grid_, first, counters, entries);
  d.run({"ccCutColumns", grid_.entryRoom, CC_CUT_GROUP}, grid_, vertices, triangles, entries,
        owners_.buffer(), counters, found_.buffer(), pieces_.buffer(), touched_.buffer());
}

void OpenClDigitizer::sum() {
  Device& d = *device_;
  const cl::Buffer &counters = deviceCounters_.buffer(), &table = deviceTable_.buffer(),
                   &stored = stored_.buffer(), &firstStored = firstStored_.buffer();
  d.run({"ccPlaceLayers", columns_ * CC_COLUMNS, CC_COLUMNS}, grid_, touched_.buffer(), counters,
        placed_.buffer());
  d.run({"ccAddPieces", std::min<std::size_t>(grid_.sumRoom, kMostGroups) * CC_COLUMNS, CC_COLUMNS},
        grid_, first_.buffer(), placed_.buffer(), found_.buffer(), pieces_.buffer(), counters,
        sums_.buffer());
  d.run({"ccSumColumns", columns_ * CC_COLUMNS, CC_COLUMNS}, grid_, first_.buffer(),
        entries_.buffer(), shells_.buffer(), found_.buffer(), touched_.buffer(), sums_.buffer(),
        counters, table, stored);
  d.run({"ccScan", CC_SCAN_GROUP, CC_SCAN_GROUP}, stored, static_cast<cl_uint>(columns_),
        firstStored, counters, cl_uint{CC_STORED});
  d.run({"ccStoreBricks", columns_ * CC_COLUMNS, CC_COLUMNS}, grid_, touched_.buffer(),
        sums_.buffer(), counters, firstStored, table, bricks_.buffer());
}

void OpenClDigitizer::sendWindow(const Bricks& field) {
  density_.fill(*device_, field.density, "window sent");
  taps_.send(*device_, field.window, "window sent");
  const std::size_t taps = field.window.taps.size();
  windows_ = {field.bricks.x(), field.bricks.y(),          field.bricks.z(), {0, 0, 0},
              {0, 0, 0},        static_cast<cl_int>(taps), field.density[0], windows_.blockRoom};
  for (int k = 0; k < 3; ++k) {
    windows_.low[k] = field.window.low[k];
    windows_.high[k] = field.window.high[k];
  }
  report_.taps = taps;
  report_.sent += sizeof(FieldBlock) + sizeof(int) * field.density.size() + taps_.sentBytes();
}

void OpenClDigitizer::sumWindows(const Bricks& field) {
  Device& d = *device_;
  const auto count = static_cast<cl_uint>(table_);
  const cl::Buffer &table = deviceTable_.buffer(), &counters = deviceCounters_.buffer(),
                   &bricks = bricks_.buffer();
  const auto groupsOwn = static_cast<cl_uint>((table_ + CC_GROUP - 1) / CC_GROUP);
  const cl::Buffer& own = own_.reserve(d, table_ * sizeof(cl_uint));
  const cl::Buffer& ownGroups = ownGroups_.reserve(d, groupsOwn * sizeof(cl_uint));
  const cl::Buffer& firstOwn = firstOwn_.reserve(d, (std::size_t{groupsOwn} + 1) * sizeof(cl_uint));
  const cl::Buffer& blockOf = blockOf_.reserve(d, table_ * sizeof(cl_int));
  const cl::Buffer& list = list_.reserve(d, windows_.blockRoom * sizeof(cl_uint));
  const cl::Buffer& blocks = blocks_.reserve(d, std::size_t{windows_.blockRoom} * sizeof(CcBlock));
  d.send(field.blocks.data(), blocks, sizeof(CcBlock), "window sent");
  d.run({"ccOwnBlocks", table_, CC_GROUP}, windows_, table, count, own, ownGroups);
  d.run({"ccScan", CC_SCAN_GROUP, CC_SCAN_GROUP}, ownGroups, groupsOwn, firstOwn, counters,
        cl_uint{CC_OWN_BLOCKS});
  d.run({"ccBlockTable", table_, CC_GROUP}, windows_, table, count, own, firstOwn, blockOf, list);
  const std::size_t groups = std::min<std::size_t>(windows_.blockRoom, kMostGroups);
  if (taps_.flat()) {
    d.run({"ccSumWindows", groups * CC_COLUMNS, CC_COLUMNS}, windows_, table, bricks, taps_.taps(),
          taps_.runs(), taps_.runCount(), list, counters, blocks, cl::Local(taps_.tileBytes()));
    return;
  }
  d.run({"ccFillBlocks", groups * CC_WINDOW_GROUP, CC_WINDOW_GROUP}, windows_, table, bricks, list,
        counters, blocks);
  d.run({"ccSumAnyWindows", groups * CC_WINDOW_GROUP, CC_WINDOW_GROUP}, windows_, blockOf,
        taps_.taps(), density_.buffer(), list, counters, blocks);
}

// Runs the chain until all buffers are large enough. Returns why the CPU must do it instead, or
// nothing.
std::string OpenClDigitizer::runChain(const GridSurface& surface, const StartField& start) {
  Device& d = *device_;
  const Bricks* field = nullptr;
  const bool withField = static_cast<bool>(start);
  for (int round = 0;; ++round) {
    if (const std::string why = lacking(withField); !why.empty()) return why;
    if (round == kMaxRounds) return "it needs more memory in every round";
    reserve();
    if (round == 0) send(surface);
    cut();
    sum();
    d.queue().flush();
    if (withField && !field) {
      field = start();
      sendWindow(*field);
    }
    if (field) sumWindows(*field);
    d.fetch(deviceCounters_.buffer(), counters_.data(), sizeof counters_, "counters fetched");
    report_.rounds = std::size_t(round) + 1;
    if (!enlarge(withField)) return {};
  }
}

std::string OpenClDigitizer::run(const GridSurface& surface, int axis, const StartField& start) {
  report_ = {};
  report_.triangles = surface.triangles.size();
  if (static_cast<double>(surface.bricks[axis]) * kBrickEdge + 1 > CC_TALLEST)
    return "its columns are taller than " + std::to_string(CC_TALLEST) + " voxels";
  const Frame frame(surface, axis);
  if (double(surface.triangles.size()) * frame.width * frame.depth > kMaxListed &&
      maxListed(surface, frame) > kMaxListed)
    return "its triangles lie over more columns than can be listed";
  const bool field = static_cast<bool>(start);
  guess(surface, axis, field);
  // The sizes of earlier meshes may be too large together with this one's.
  if (!lacking(field).empty()) {
    release();
    guess(surface, axis, field);
  }
  try {
    // The next mesh overwrites this one's pinned memory, and `start` may throw during the upload.
    std::string why = settled(device_->queue(), [&] { return runChain(surface, start); });
    if (!why.empty()) {
      release();
      return why;
    }
  } catch (...) {
    release();
    throw;
  }
  report_.listed = counters_[CC_ENTRIES];
  report_.places = std::size_t{counters_[CC_PIECES]} * CC_PIECE_UNIT;
  report_.touched = counters_[CC_SUM_BRICKS];
  report_.stored = counters_[CC_STORED];
  report_.blocks = counters_[CC_OWN_BLOCKS];
  if (counters_[CC_OVERLAPPING] > 0)
    return "shells lie within or across each other in " +
           std::to_string(counters_[CC_OVERLAPPING]) + " columns";
  if (counters_[CC_LOST] > 0) return "pieces of a triangle lie outside its height";
  report_.onDevice = true;
  return {};
}

// All device buffers.
template <typename Self>
auto OpenClDigitizer::buffers(Self& self) {
  return std::array{&self.surface_, &self.triangles_,   &self.shells_,    &self.deviceCounters_,
                    &self.counts_,  &self.first_,       &self.entries_,   &self.owners_,
                    &self.found_,   &self.pieces_,      &self.touched_,   &self.placed_,
                    &self.sums_,    &self.deviceTable_, &self.stored_,    &self.firstStored_,
                    &self.bricks_,  &self.own_,         &self.ownGroups_, &self.firstOwn_,
                    &self.blockOf_, &self.list_,        &self.density_,   &self.blocks_};
}

// Frees all memory; the next mesh starts afresh.
void OpenClDigitizer::release() {
  for (DeviceBuffer* g : buffers(*this)) *g = {};
  taps_ = {};
  grid_ = {};
  windows_ = {};
}

std::size_t OpenClDigitizer::bytes() const {
  std::size_t sum = 0;
  for (const DeviceBuffer* g : buffers(*this)) sum += g->bytes();
  for (const DeviceBuffer* g : taps_.buffers()) sum += g->bytes();
  return sum;
}

Cloud::Voxels OpenClDigitizer::voxels() {
  Device& d = *device_;
  Cloud::Voxels voxels;
  voxels.bricks = {grid_.nx, grid_.ny, 0};
  voxels.bricks[2] = static_cast<int>(table_ / (std::size_t(grid_.nx) * std::size_t(grid_.ny)));
  voxels.table.resize(table_);
  voxels.coverage.resize(counters_[CC_STORED]);
  d.fetch(deviceTable_.buffer(), voxels.table.data(), table_ * sizeof(cl_int), "voxels fetched");
  if (!voxels.coverage.empty())
    d.fetch(bricks_.buffer(), voxels.coverage.data(),
            voxels.coverage.size() * sizeof(BrickCoverage), "voxels fetched");
  return voxels;
}

void OpenClDigitizer::fetchTable(Bricks& to) {
  to.table.resize(table_);
  device_->fetch(blockOf_.buffer(), to.table.data(), table_ * sizeof(cl_int), "field fetched");
}

void OpenClDigitizer::fetchField(Bricks& to) {
  fetchTable(to);
  to.blocks.resize(blockCount());
  device_->fetch(blocks_.buffer(), to.blocks.data(), to.blocks.size() * sizeof(FieldBlock),
                 "field fetched");
}

}  // namespace cloudcontact::opencl
