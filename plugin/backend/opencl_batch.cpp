// One upload, one chain of kernels, one download.
#include "opencl_batch.h"

#include <algorithm>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>

namespace cloudcontact::opencl {

namespace {

// Bins and patches that a pair is first given room for: a M16 thread has 80 and 12.
constexpr std::uint32_t kBins = 128, kPatches = 24;
constexpr std::size_t kLanes = 4096 * CC_GROUP;  // work-items that take bins or patches in turn

CcPair pairOf(const Asked& asked) {
  CcPair p{};
  p.voxel = asked.frame.voxel;
  p.cell = cellOf(asked.frame, 0);
  p.margin = marginOf(asked.pair->settings.margin, asked.frame);
  const std::size_t enough = enoughFor(asked.pair->settings);
  for (int level = 0; level < kLevels; ++level)
    p.enough[level] = static_cast<std::uint32_t>(
        std::min<std::size_t>(neededOf(level, enough), std::numeric_limits<std::uint32_t>::max()));
  return p;
}

const FieldData& dataOf(const ContactBody& body) {
  return static_cast<const FieldData&>(*body.field);
}

}  // namespace

void* Pinned::room(Device& device, std::size_t size) {
  if (size <= size_) return data_;
  if (data_) device.queue().enqueueUnmapMemObject(buffer_, data_);
  size_ = size + size / 4;
  buffer_ = cl::Buffer(device.context(), CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, size_);
  data_ = device.queue().enqueueMapBuffer(buffer_, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, size_);
  return data_;
}

const cl::Buffer& Grown::room(Device& device, std::size_t size) {
  if (size > size_) {
    buffer_ = cl::Buffer();
    size_ = size + size / 4;
    if (size_ > device.largestBuffer()) throw std::bad_alloc();  // the batch is halved
    buffer_ = cl::Buffer(device.context(), CL_MEM_READ_WRITE, size_);
  }
  return buffer_;
}

OpenClBatch::OpenClBatch(std::shared_ptr<Device> device)
    : device_(std::move(device)), fields_(device_) {}

std::size_t OpenClBatch::bytes() const {
  std::size_t sum = fields_.bytes();
  for (const Grown* g : {&pairs_, &directions_, &counters_, &found_, &nearby_, &hits_, &aside_,
                         &keys_, &slots_, &order_, &answersThere_, &bins_, &sums_, &sprouts_,
                         &queues_, &scratch_, &grown_, &patches_})
    sum += g->bytes();
  return sum;
}

void OpenClBatch::send(std::span<const Asked> pairs, BatchReport& report) {
  const std::size_t n = pairs.size(), ways = 2 * n * sizeof(CcDirection);
  unsigned char* const to =
      static_cast<unsigned char*>(sent_.room(*device_, ways + n * sizeof(CcPair)));
  auto* const directions = reinterpret_cast<CcDirection*>(to);
  auto* const tasks = reinterpret_cast<CcPair*>(to + ways);
  std::size_t hits = 0, nearby = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const Asked& asked = pairs[k];
    tasks[k] = pairOf(asked);
    for (int side = 0; side < 2; ++side) {
      const ContactBody &own = side == 0 ? asked.pair->a : asked.pair->b,
                        &other = side == 0 ? asked.pair->b : asked.pair->a;
      CcDirection& d = directions[2 * k + static_cast<std::size_t>(side)];
      d.way = wayOf(own, other, asked.frame);
      d.own = fields_.numberOf(dataOf(own));
      d.other = fields_.numberOf(dataOf(other));
      d.hits = static_cast<std::uint32_t>(hits);
      d.room = asked.room[side];
      hits += d.room;
      for (int level : {2, 1}) {
        d.nearby[level == 1] = static_cast<std::uint32_t>(nearby);
        nearby += dataOf(own).samples().levels[level].samples.size();
      }
    }
  }
  if (std::max(hits, nearby) > std::numeric_limits<std::uint32_t>::max() / 4)
    throw std::bad_alloc();
  hitRoom_ = hits;
  nearbyRoom_ = nearby;
  fields_.settle();
  cl::CommandQueue& queue = device_->queue();
  queue.enqueueWriteBuffer(directions_.room(*device_, ways), CL_FALSE, 0, ways, directions, nullptr,
                           device_->note("poses sent"));
  queue.enqueueWriteBuffer(pairs_.room(*device_, n * sizeof(CcPair)), CL_FALSE, 0,
                           n * sizeof(CcPair), tasks, nullptr, device_->note("poses sent"));
  queue.enqueueFillBuffer(counters_.room(*device_, CC_COUNTERS * sizeof(cl_uint)), cl_uint{0}, 0,
                          CC_COUNTERS * sizeof(cl_uint));
  report.sent += ways + n * sizeof(CcPair);
}

namespace {

template <typename... Arguments>
void give(cl::Kernel& kernel, const Arguments&... arguments) {
  cl_uint k = 0;
  (kernel.setArg(k++, arguments), ...);
}

}  // namespace

void OpenClBatch::launch(std::size_t n) {
  Device& d = *device_;
  const std::size_t hits = std::max<std::size_t>(hitRoom_, 1), none = 0;
  binRoom_ = std::max(static_cast<std::uint32_t>(n) * kBins, binsWanted_ + binsWanted_ / 4);
  patchRoom_ =
      std::max(static_cast<std::uint32_t>(n) * kPatches, patchesWanted_ + patchesWanted_ / 4);
  const cl::Buffer &data = fields_.data(), &pairs = pairs_.room(d, none),
                   &directions = directions_.room(d, none), &counters = counters_.room(d, none);
  const cl::Buffer& found = found_.room(d, 2 * n * kLevels * sizeof(CcFound));
  const cl::Buffer& nearby = nearby_.room(d, std::max<std::size_t>(nearbyRoom_, 1) * 4);
  const cl::Buffer& hitsThere = hits_.room(d, hits * 64);
  const cl::Buffer& aside = aside_.room(d, hits * 8);
  const cl::Buffer& keys = keys_.room(d, hits * 8);
  const cl::Buffer& slots = slots_.room(d, hits * 4);
  const cl::Buffer& order = order_.room(d, hits * 4);
  const cl::Buffer& answers = answersThere_.room(d, n * sizeof(CcAnswer));
  const cl::Buffer& bins = bins_.room(d, binRoom_ * sizeof(CcBin));
  const cl::Buffer& sums = sums_.room(d, binRoom_ * sizeof(CcSums));
  const cl::Buffer& sprouts = sprouts_.room(d, binRoom_ * sizeof(CcSprout));
  const cl::Buffer& queues = queues_.room(d, binRoom_ * sizeof(cl_uint));
  const cl::Buffer& scratch = scratch_.room(d, binRoom_ * sizeof(CcGrown));
  const cl::Buffer& grown = grown_.room(d, patchRoom_ * sizeof(CcGrown));
  const cl::Buffer& patches = patches_.room(d, patchRoom_ * sizeof(CcSums));

  static constexpr const char* kNames[kLevels] = {"ccSearch 0", "ccSearch 1", "ccSearch 2"};
  cl::Kernel& search = d.kernel("ccSearch");
  for (cl_int level = kLevels - 1; level >= 0; --level) {
    give(search, level, fields_.table(), data, data, data, data, data, pairs, directions, found,
         nearby, hitsThere, aside);
    d.run(search, kNames[level], 2 * n * CC_GROUP, CC_GROUP);
  }
  give(d.kernel("ccBins"), pairs, directions, found, hitsThere, keys, slots, order, answers, bins,
       counters, binRoom_);
  d.run("ccBins", n * CC_GROUP, CC_GROUP);
  const std::size_t some = std::min(kLanes, std::size_t{4} * binRoom_);
  give(d.kernel("ccSums"), pairs, directions, found, answers, hitsThere, order, bins, counters,
       binRoom_, sums);
  d.run("ccSums", some, CC_GROUP);
  give(d.kernel("ccSprouts"), bins, sums, counters, binRoom_, sprouts);
  d.run("ccSprouts", std::min(kLanes, std::size_t{binRoom_}), 64);
  give(d.kernel("ccGrow"), pairs, answers, sums, sprouts, queues, scratch, grown, counters,
       patchRoom_);
  d.run("ccGrow", n * CC_TEAM, CC_TEAM);
  give(d.kernel("ccPatches"), sums, queues, grown, counters, patchRoom_, patches);
  d.run("ccPatches", std::min(kLanes, std::size_t{patchRoom_}), 64);
}

void OpenClBatch::fetch(std::size_t n, BatchReport& report) {
  Device& d = *device_;
  const std::size_t size = n * sizeof(CcAnswer);
  auto* const to = static_cast<unsigned char*>(fetched_.room(d, size + 64));
  auto* const counters = reinterpret_cast<const std::uint32_t*>(to + size);
  cl::CommandQueue& queue = d.queue();
  queue.enqueueReadBuffer(answersThere_.room(d, 0), CL_FALSE, 0, size, to, nullptr,
                          d.note("answers fetched"));
  queue.enqueueReadBuffer(counters_.room(d, 0), CL_TRUE, 0, CC_COUNTERS * sizeof(cl_uint),
                          to + size);
  answers_ = reinterpret_cast<const CcAnswer*>(to);
  binsWanted_ = counters[CC_BINS];
  patchesWanted_ = counters[CC_PATCHES];
  const std::size_t patches = std::min(patchesWanted_, patchRoom_);
  void* const sums = fetchedSums_.room(d, std::max<std::size_t>(patches, 1) * sizeof(CcSums));
  if (patches > 0)
    queue.enqueueReadBuffer(patches_.room(d, 0), CL_TRUE, 0, patches * sizeof(CcSums), sums,
                            nullptr, d.note("patches fetched"));
  sumsHere_ = static_cast<const Sums*>(sums);
  report.fetched += size + patches * sizeof(CcSums);
  report.bins += counters[CC_BINS];
  report.patches += patches;
  for (std::size_t k = 0; k < n; ++k) {
    report.asked += answers_[k].asked;
    report.hits += answers_[k].hits;
  }
}

void OpenClBatch::run(std::span<const Asked> pairs, BatchReport& report) {
  static_assert(sizeof(Sums) == sizeof(CcSums));
  try {
    send(pairs, report);
    launch(pairs.size());
    fetch(pairs.size(), report);
  } catch (const cl::Error& e) {
    if (e.err() == CL_MEM_OBJECT_ALLOCATION_FAILURE || e.err() == CL_OUT_OF_RESOURCES)
      throw std::bad_alloc();
    throw std::runtime_error("OpenCL: " + device_->name() + " failed: " + e.what() + " gave " +
                             std::to_string(e.err()));
  }
}

std::span<const Sums> OpenClBatch::patches(std::size_t k) const {
  return {sumsHere_ + answers_[k].firstPatch, answers_[k].patches};
}

}  // namespace cloudcontact::opencl
