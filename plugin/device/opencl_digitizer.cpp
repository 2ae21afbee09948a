// One upload, one chain of kernels, one look at what it counted. Where something found no room the
// chain runs again with as much as it asked for.
#include "device/opencl_digitizer.h"

#include "device/device_guard.h"
#include "device/flat_taps.h"
#include "voxels/column_cutter.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>

namespace cloudcontact::opencl {

namespace {

using Bricks = BaseVectorField::Bricks;

constexpr std::size_t kGroups = 1 << 15;          // that take bricks in turn
constexpr std::size_t kMostPlaces = 0xffffffffu;  // that 32 bits count
constexpr double kMostUnits = double(kMostPlaces) / CC_PIECE_UNIT - 1;
constexpr double kMostListed = 1e9;
// Places for pieces that a chain is first given, by the triangles listed over columns: the M16 bolt
// at 512 voxels takes 40.
constexpr std::size_t kPieces = 64;
constexpr int kRounds = 6;

std::size_t bounded(double wanted, double most) {
  return static_cast<std::size_t>(std::clamp(wanted, 64.0, most));
}

std::string megabytes(double bytes) {
  return std::to_string(std::llround(bytes / 1e6)) + " MB";
}

// How many triangles at most will be listed, were each to fill its box.
double mostListed(const GridSurface& surface, const Frame& frame) {
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
  windows_.blockRoom = static_cast<cl_uint>(std::min(blocks, mostBlocks()));
}

// One for every brick, and the shared one.
std::size_t OpenClDigitizer::mostBlocks() const {
  return std::min(table_ + 1, kMostPlaces);
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
  const bool asBefore = grid_.triangles == before.triangles && grid_.width == before.width &&
                        grid_.depth == before.depth && grid_.layers == before.layers;
  if (asBefore) return;
  bins_ = static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.depth);
  table_ = bins_ * static_cast<std::size_t>(frame.layers);
  constexpr double kEnough = 4e6;  // to begin with
  const double listed = std::min(mostListed(surface, frame), kEnough),
               all = static_cast<double>(table_ + bins_);
  const auto raise = [](cl_uint& room, std::size_t wanted) {
    room = std::max(room, static_cast<cl_uint>(std::min(wanted, kMostPlaces)));
  };
  raise(grid_.entryRoom, bounded(listed, 1e9));
  raise(grid_.pieceRoom, bounded(kPieces * listed / CC_PIECE_UNIT, kMostUnits));
  raise(grid_.sumRoom, bounded(listed / 2, all));
  raise(grid_.brickRoom, bounded(listed / 2, all));
}

// What does not fit into the device as it stands; empty where all does.
std::string OpenClDigitizer::lacking(bool field) const {
  const double needs[] = {
      double(grid_.entryRoom) * CC_COLUMNS * sizeof(CcColumnPieces),
      double(grid_.pieceRoom) * CC_PIECE_UNIT * 2 * sizeof(double),
      double(grid_.sumRoom) * CC_BRICK_VOXELS * sizeof(double),
      double(grid_.brickRoom) * CC_BRICK_VOXELS,
      double(bins_) * (grid_.layers + 1) * sizeof(cl_int),
      field ? double(windows_.blockRoom) * sizeof(CcBlock) : 0.0,
  };
  double sum = 0, most = 0;
  for (const double n : needs) sum += n, most = std::max(most, n);
  const double margin = 1.25;  // Grown's
  if (margin * most <= double(device_->largestBuffer()) &&
      margin * sum <= 0.9 * double(device_->memory()))
    return {};
  return "it would take " + megabytes(margin * sum) + " on the device, " +
         megabytes(margin * most) + " of them in one buffer";
}

// Room for what the chain asked for; whether it had not enough.
bool OpenClDigitizer::enlarge(bool field) {
  bool more = false;
  const auto enough = [&](cl_uint& room, int counter, cl_uint extra = 0,
                          std::size_t most = kMostPlaces) {
    const std::size_t wanted = std::size_t{counters_[std::size_t(counter)]} + extra;
    if (wanted <= room) return;
    room = static_cast<cl_uint>(std::min(wanted + wanted / 8, most));
    more = true;
  };
  enough(grid_.entryRoom, CC_ENTRIES);
  enough(grid_.pieceRoom, CC_PIECES);
  grid_.pieceRoom = static_cast<cl_uint>(std::min<double>(grid_.pieceRoom, kMostUnits));
  enough(grid_.sumRoom, CC_SUM_BRICKS);
  enough(grid_.brickRoom, CC_STORED);
  if (field) enough(windows_.blockRoom, CC_OWN_BLOCKS, 1, mostBlocks());
  return more;
}

void OpenClDigitizer::send(const GridSurface& surface) {
  Device& d = *device_;
  const std::size_t n = surface.vertices.size(), t = surface.triangles.size();
  const std::size_t vertices = n * 3 * sizeof(double), triangles = t * 3 * sizeof(cl_int),
                    shells = surface.component.size() * sizeof(cl_int);
  auto* const to = static_cast<unsigned char*>(sent_.room(d, vertices + triangles + shells));
  static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double) &&
                sizeof(Eigen::Vector3i) == 3 * sizeof(cl_int));
  std::memcpy(to, surface.vertices.data(), vertices);
  std::memcpy(to + vertices, surface.triangles.data(), triangles);
  auto* const shellsHere = reinterpret_cast<cl_int*>(to + vertices + triangles);
  std::copy(surface.component.begin(), surface.component.end(), shellsHere);
  if (shells > 0) std::fill(shellsHere + surface.firstCap, shellsHere + t, cl_int{-1});
  const auto write = [&](Grown& buffer, std::size_t begin, std::size_t size) {
    const cl::Buffer& there = buffer.room(d, std::max<std::size_t>(size, 16));
    if (size > 0)
      d.queue().enqueueWriteBuffer(there, CL_FALSE, 0, size, to + begin, nullptr,
                                   d.note("mesh sent"));
  };
  write(surface_, 0, vertices);
  write(triangles_, vertices, triangles);
  write(shells_, vertices + triangles, shells);
  d.queue().flush();
  report_.sent += vertices + triangles + shells;
}

void OpenClDigitizer::makeRoom() {
  Device& d = *device_;
  const auto clear = [&](Grown& buffer, std::size_t count) {
    d.queue().enqueueFillBuffer(buffer.room(d, count * sizeof(cl_uint)), cl_uint{0}, 0,
                                count * sizeof(cl_uint), nullptr, d.note("cleared"));
  };
  clear(countersThere_, CC_CUT_COUNTERS);
  clear(counts_, bins_);
  clear(touched_, bins_ * static_cast<std::size_t>(grid_.layers + 1));
  first_.room(d, (bins_ + 1) * sizeof(cl_uint));
  entries_.room(d, grid_.entryRoom * sizeof(cl_uint));
  owners_.room(d, grid_.entryRoom * sizeof(cl_uint));
  found_.room(d, std::size_t{grid_.entryRoom} * CC_COLUMNS * sizeof(CcColumnPieces));
  pieces_.room(d, std::size_t{grid_.pieceRoom} * CC_PIECE_UNIT * 2 * sizeof(double));
  placed_.room(d, grid_.sumRoom * sizeof(cl_uint));
  sums_.room(d, std::size_t{grid_.sumRoom} * CC_BRICK_VOXELS * sizeof(double));
  tableThere_.room(d, table_ * sizeof(cl_int));
  stored_.room(d, bins_ * sizeof(cl_uint));
  firstStored_.room(d, (bins_ + 1) * sizeof(cl_uint));
  bricks_.room(d, std::size_t{grid_.brickRoom} * CC_BRICK_VOXELS);
}

void OpenClDigitizer::cut() {
  Device& d = *device_;
  constexpr std::size_t kRowItems = 8;  // CC_ROW_ITEMS
  const std::size_t items = kRowItems * grid_.triangles;
  const cl::Buffer &vertices = surface_.buffer(), &triangles = triangles_.buffer(),
                   &counters = countersThere_.buffer(), &counts = counts_.buffer(),
                   &first = first_.buffer(), &entries = entries_.buffer();
  give(d.kernel("ccCountColumns"), grid_, vertices, triangles, counts);
  d.run("ccCountColumns", items, CC_GROUP);
  give(d.kernel("ccScan"), counts, static_cast<cl_uint>(bins_), first, counters,
       cl_uint{CC_ENTRIES});
  d.run("ccScan", CC_SCAN_GROUP, CC_SCAN_GROUP);
  d.queue().enqueueFillBuffer(counts, cl_uint{0}, 0, bins_ * sizeof(cl_uint), nullptr,
                              d.note("cleared"));
  give(d.kernel("ccListColumns"), grid_, vertices, triangles, counts, first, counters, entries,
       owners_.buffer());
  d.run("ccListColumns", items, CC_GROUP);
  give(d.kernel("ccSortColumns"), grid_, first, counters, entries);
  d.run("ccSortColumns", bins_ * CC_GROUP, CC_GROUP);
  give(d.kernel("ccCutColumns"), grid_, vertices, triangles, entries, owners_.buffer(), counters,
       found_.buffer(), pieces_.buffer(), touched_.buffer());
  d.run("ccCutColumns", grid_.entryRoom, CC_CUT_GROUP);
}

void OpenClDigitizer::sum() {
  Device& d = *device_;
  const cl::Buffer &counters = countersThere_.buffer(), &table = tableThere_.buffer(),
                   &stored = stored_.buffer(), &firstStored = firstStored_.buffer();
  give(d.kernel("ccPlaceLayers"), grid_, touched_.buffer(), counters, placed_.buffer());
  d.run("ccPlaceLayers", bins_ * CC_COLUMNS, CC_COLUMNS);
  give(d.kernel("ccAddPieces"), grid_, first_.buffer(), placed_.buffer(), found_.buffer(),
       pieces_.buffer(), counters, sums_.buffer());
  d.run("ccAddPieces", std::min<std::size_t>(grid_.sumRoom, kGroups) * CC_COLUMNS, CC_COLUMNS);
  give(d.kernel("ccSumColumns"), grid_, first_.buffer(), entries_.buffer(), shells_.buffer(),
       found_.buffer(), touched_.buffer(), sums_.buffer(), counters, table, stored);
  d.run("ccSumColumns", bins_ * CC_COLUMNS, CC_COLUMNS);
  give(d.kernel("ccScan"), stored, static_cast<cl_uint>(bins_), firstStored, counters,
       cl_uint{CC_STORED});
  d.run("ccScan", CC_SCAN_GROUP, CC_SCAN_GROUP);
  give(d.kernel("ccStoreBricks"), grid_, touched_.buffer(), sums_.buffer(), counters, firstStored,
       table, bricks_.buffer());
  d.run("ccStoreBricks", bins_ * CC_COLUMNS, CC_COLUMNS);
}

void OpenClDigitizer::sendWindow(const Bricks& field) {
  Device& d = *device_;
  flat_ = mayBeFlat(field.window, d.localBytes());
  const std::vector<CcWindowTap> any = windowTaps(field.window);
  const auto write = [&](Grown& buffer, const auto& values) {
    const std::size_t bytes = values.size() * sizeof(values[0]);
    auto* const to = static_cast<unsigned char*>(sentWindow_.data()) + sentBytes_;
    std::memcpy(to, static_cast<const void*>(values.data()), bytes);
    sentBytes_ += bytes;
    d.queue().enqueueWriteBuffer(buffer.room(d, bytes), CL_FALSE, 0, bytes, to, nullptr,
                                 d.note("window sent"));
  };
  sentWindow_.room(d, sizeof(FieldBlock) + (any.size() + 1) * sizeof(CcWindowTap) +
                          any.size() * (sizeof(cl_float4) + sizeof(CcFlatRun)));
  std::memcpy(sentWindow_.data(), static_cast<const void*>(field.blocks.data()),
              sizeof(FieldBlock));
  sentBytes_ = sizeof(FieldBlock);
  write(density_, field.density);
  if (flat_) {
    const FlatTaps taps(field.window);
    runCount_ = static_cast<cl_uint>(taps.runs.size());
    write(taps_, taps.by);
    write(runs_, taps.runs);
  } else {
    write(taps_, any);
  }
  windows_ = {field.bricks.x(), field.bricks.y(),  field.bricks.z(),
              {0, 0, 0},        {0, 0, 0},         static_cast<cl_int>(any.size()),
              field.density[0], windows_.blockRoom};
  for (int k = 0; k < 3; ++k) {
    windows_.low[k] = field.window.low[k];
    windows_.high[k] = field.window.high[k];
  }
  tile_ = flatTile(field.window);
  report_.taps = any.size();
  report_.sent += sentBytes_;
}

void OpenClDigitizer::sumWindows(const Bricks& field) {
  Device& d = *device_;
  const auto count = static_cast<cl_uint>(table_);
  const cl::Buffer &table = tableThere_.buffer(), &counters = countersThere_.buffer(),
                   &bricks = bricks_.buffer();
  const auto groupsOwn = static_cast<cl_uint>((table_ + CC_GROUP - 1) / CC_GROUP);
  const cl::Buffer& own = own_.room(d, table_ * sizeof(cl_uint));
  const cl::Buffer& ownGroups = ownGroups_.room(d, groupsOwn * sizeof(cl_uint));
  const cl::Buffer& firstOwn = firstOwn_.room(d, (std::size_t{groupsOwn} + 1) * sizeof(cl_uint));
  const cl::Buffer& blockOf = blockOf_.room(d, table_ * sizeof(cl_int));
  const cl::Buffer& list = list_.room(d, windows_.blockRoom * sizeof(cl_uint));
  const cl::Buffer& blocks = blocks_.room(d, std::size_t{windows_.blockRoom} * sizeof(CcBlock));
  d.queue().enqueueWriteBuffer(blocks, CL_FALSE, 0, sizeof(CcBlock), sentWindow_.data(), nullptr,
                               d.note("window sent"));
  static_assert(sizeof(CcBlock) == sizeof(field.blocks[0]));
  give(d.kernel("ccOwnBlocks"), windows_, table, count, own, ownGroups);
  d.run("ccOwnBlocks", table_, CC_GROUP);
  give(d.kernel("ccScan"), ownGroups, groupsOwn, firstOwn, counters, cl_uint{CC_OWN_BLOCKS});
  d.run("ccScan", CC_SCAN_GROUP, CC_SCAN_GROUP);
  give(d.kernel("ccBlockTable"), windows_, table, count, own, firstOwn, blockOf, list);
  d.run("ccBlockTable", table_, CC_GROUP);
  const std::size_t groups = std::min<std::size_t>(windows_.blockRoom, kGroups);
  if (flat_) {
    give(d.kernel("ccSumWindows"), windows_, table, bricks, taps_.buffer(), runs_.buffer(),
         runCount_, list, counters, blocks, cl::Local(tile_ * sizeof(cl_half)));
    d.run("ccSumWindows", groups * CC_COLUMNS, CC_COLUMNS);
    return;
  }
  give(d.kernel("ccFillBlocks"), windows_, table, bricks, list, counters, blocks);
  d.run("ccFillBlocks", groups * CC_WINDOW_GROUP, CC_WINDOW_GROUP);
  give(d.kernel("ccSumAnyWindows"), windows_, blockOf, taps_.buffer(), density_.buffer(), list,
       counters, blocks);
  d.run("ccSumAnyWindows", groups * CC_WINDOW_GROUP, CC_WINDOW_GROUP);
}

// The chain of kernels, again where it found no room. Why the device cannot do it; empty where it
// is done.
std::string OpenClDigitizer::runChain(const GridSurface& surface, const StartField& start) {
  Device& d = *device_;
  const Bricks* field = nullptr;
  const bool wanted = static_cast<bool>(start);
  for (int round = 0;; ++round) {
    if (const std::string why = lacking(wanted); !why.empty()) return why;
    if (round == kRounds) return "it asks for ever more room";
    makeRoom();
    if (round == 0) send(surface);
    cut();
    sum();
    d.queue().flush();
    if (wanted && !field) {
      field = start();
      sendWindow(*field);
    }
    if (field) sumWindows(*field);
    d.queue().enqueueReadBuffer(countersThere_.buffer(), CL_TRUE, 0, sizeof counters_,
                                counters_.data(), nullptr, d.note("counters fetched"));
    report_.rounds = std::size_t(round) + 1;
    if (!enlarge(wanted)) return {};
  }
}

std::string OpenClDigitizer::run(const GridSurface& surface, int axis, const StartField& start) {
  report_ = {};
  report_.triangles = surface.triangles.size();
  if (static_cast<double>(surface.bricks[axis]) * kBrickEdge + 1 > CC_TALLEST)
    return "its columns are taller than " + std::to_string(CC_TALLEST) + " voxels";
  const Frame frame(surface, axis);
  if (double(surface.triangles.size()) * frame.width * frame.depth > kMostListed &&
      mostListed(surface, frame) > kMostListed)
    return "its triangles lie over more columns than can be listed";
  const bool field = static_cast<bool>(start);
  guess(surface, axis, field);
  // What other meshes wanted does not keep this one off.
  if (!lacking(field).empty()) {
    giveBack();
    guess(surface, axis, field);
  }
  try {
    // The next mesh is written over this one's, and a window may be refused when that is on its
    // way.
    std::string why = settled(device_->queue(), [&] { return runChain(surface, start); });
    if (!why.empty()) {
      giveBack();
      return why;
    }
  } catch (...) {
    giveBack();
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
  if (counters_[CC_LOST] > 0) return "a triangle's pieces left its own height";
  report_.onDevice = true;
  return {};
}

// All that is held on the device.
template <typename Self>
auto OpenClDigitizer::held(Self& self) {
  return std::array{&self.surface_, &self.triangles_,  &self.shells_,    &self.countersThere_,
                    &self.counts_,  &self.first_,      &self.entries_,   &self.owners_,
                    &self.found_,   &self.pieces_,     &self.touched_,   &self.placed_,
                    &self.sums_,    &self.tableThere_, &self.stored_,    &self.firstStored_,
                    &self.bricks_,  &self.own_,        &self.ownGroups_, &self.firstOwn_,
                    &self.blockOf_, &self.list_,       &self.taps_,      &self.runs_,
                    &self.density_, &self.blocks_};
}

// The next mesh begins as the first did.
void OpenClDigitizer::giveBack() {
  for (Grown* g : held(*this)) *g = {};
  grid_ = {};
  windows_ = {};
}

std::size_t OpenClDigitizer::bytes() const {
  std::size_t sum = 0;
  for (const Grown* g : held(*this)) sum += g->bytes();
  return sum;
}

Cloud::Voxels OpenClDigitizer::voxels() {
  Device& d = *device_;
  Cloud::Voxels voxels;
  voxels.bricks = {grid_.nx, grid_.ny, 0};
  voxels.bricks[2] = static_cast<int>(table_ / (std::size_t(grid_.nx) * std::size_t(grid_.ny)));
  voxels.table.resize(table_);
  voxels.coverage.resize(counters_[CC_STORED]);
  d.queue().enqueueReadBuffer(tableThere_.buffer(), CL_TRUE, 0, table_ * sizeof(cl_int),
                              voxels.table.data(), nullptr, d.note("voxels fetched"));
  if (!voxels.coverage.empty())
    d.queue().enqueueReadBuffer(bricks_.buffer(), CL_TRUE, 0,
                                voxels.coverage.size() * sizeof(BrickCoverage),
                                voxels.coverage.data(), nullptr, d.note("voxels fetched"));
  return voxels;
}

void OpenClDigitizer::fetchTable(Bricks& to) {
  Device& d = *device_;
  to.table.resize(table_);
  d.queue().enqueueReadBuffer(blockOf_.buffer(), CL_TRUE, 0, table_ * sizeof(cl_int),
                              to.table.data(), nullptr, d.note("field fetched"));
}

void OpenClDigitizer::fetchField(Bricks& to) {
  Device& d = *device_;
  fetchTable(to);
  to.blocks.resize(blockCount());
  d.queue().enqueueReadBuffer(blocks_.buffer(), CL_TRUE, 0, to.blocks.size() * sizeof(FieldBlock),
                              static_cast<void*>(to.blocks.data()), nullptr,
                              d.note("field fetched"));
}

}  // namespace cloudcontact::opencl
