// One upload, one chain of kernels, one download: see opencl_batch.h.
#include "device/opencl_batch.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>

namespace cloudcontact::opencl {

namespace {

// First guess of bins and patches in a pair. An M16 thread has 80 and 12.
constexpr std::uint32_t kBins = 128, kPatches = 24;
constexpr std::uint32_t kMinRoom = 2 * CC_MOST_BINS;  // for one large pair
constexpr std::size_t kHitBytes = 64;
constexpr std::size_t kMaxItems = 4096 * CC_GROUP;  // work-items, which loop over the patches

// Contacts follow the answers, at a multiple of their size, so that a kernel can count from the
// buffer's begin. No parts of buffers (clCreateSubBuffer): NVIDIA's driver 580 crashes when a part
// is released while batches grow and shrink.
std::size_t contactsAfter(std::size_t answers) {
  const std::size_t size = offsetof(CcResults, answers) + answers * sizeof(CcAnswer);
  return (size + sizeof(CcContactPatch) - 1) / sizeof(CcContactPatch);
}

CcPair pairOf(const DevicePair& pair) {
  CcPair p{};
  p.terms = termsOf(*pair.a, *pair.b, *pair.settings, pair.frame);
  p.cell = cellOf(pair.frame, 0);
  p.margin =
      static_cast<float>(marginOf(*pair.a, *pair.b, pair.frame.voxel, pair.settings->margin));
  const std::size_t enough = enoughFor(*pair.settings);
  for (int level = 0; level < kLevels; ++level)
    p.enough[level] = static_cast<std::uint32_t>(std::min<std::size_t>(
        search::neededOf(level, enough), std::numeric_limits<std::uint32_t>::max()));
  return p;
}

}  // namespace

template <typename... Arguments>
void OpenClBatch::run(const Launch& launch, const Arguments&... arguments) {
  auto known = kernels_.find(launch.kernel);
  if (known == kernels_.end())
    known = kernels_.emplace(launch.kernel, device_->newKernel(launch.kernel)).first;
  device_->enqueue(queue_, known->second.with(arguments...), launch);
}

using B = OpenClBatch;
constexpr std::array<DeviceBuffer OpenClBatch::*, 26> OpenClBatch::kBuffers = {
    &B::pairs_,     &B::results_, &B::found_,    &B::nearby_,  &B::hits_,   &B::aside_,
    &B::keys_,      &B::slots_,   &B::order_,    &B::bins_,    &B::sums_,   &B::sprouts_,
    &B::queues_,    &B::scratch_, &B::grown_,    &B::patches_, &B::forces_, &B::wholes_,
    &B::listed_,    &B::placed_,  &B::heaviest_, &B::around_,  &B::places_, &B::facing_,
    &B::neighbors_, &B::shapes_};

std::size_t OpenClBatch::bytes() const {
  std::size_t sum = 0;
  for (const auto buffer : kBuffers) sum += (this->*buffer).bytes();
  return sum;
}

// Frees everything, so that a smaller batch does not find the device full. Kernels hold buffers,
// too. A device may report memory as allocated and fail to provide it only when it is used.
void OpenClBatch::release() {
  kernels_.clear();
  for (const auto buffer : kBuffers) this->*buffer = DeviceBuffer();
  binRoom_ = patchRoom_ = 0;
  sent_.release();
  fetched_.release();
}

void OpenClBatch::reserve(std::span<const DevicePair> pairs) {
  devicePairs_ = pairs;
  count_ = pairs.size();
  enqueue([&] {
    const auto first = std::find_if(pairs.begin(), pairs.end(),
                                    [](const DevicePair& pair) { return pair.shape(); });
    clouds_ = static_cast<std::size_t>(first - pairs.begin());
    hostPairs_ = static_cast<CcPair*>(
        sent_.reserve(*device_, count_ * sizeof(CcPair) + shapes() * sizeof(CcShape)));
    hitRoom_ = nearbyRoom_ = 0;
    offsets_.resize(2 * count_);
    for (std::size_t k = 0; k < 2 * count_; ++k) {
      const DevicePair& pair = pairs[k / 2];
      Offsets& to = offsets_[k];
      if (pair.shape() && k % 2 == 1) {
        to = offsets_[k - 1];
        continue;
      }
      to.hits = static_cast<std::uint32_t>(hitRoom_);
      hitRoom_ += pair.room;
      const std::uint32_t* counts = fields_->counts(pair.fields[k % 2]);
      for (int level : {2, 1}) {
        to.nearby[level == 1] = static_cast<std::uint32_t>(nearbyRoom_);
        nearbyRoom_ += counts[level];
      }
    }
    if (std::max(hitRoom_, nearbyRoom_) > std::numeric_limits<std::uint32_t>::max() / 4)
      throw std::bad_alloc();
  });
}

void OpenClBatch::writePose(std::size_t k) {
  const DevicePair& pair = devicePairs_[k];
  hostPairs_[k] = pairOf(pair);
  if (pair.shape()) {
    const ContactBody& cloud = pair.a->shape ? *pair.b : *pair.a;
    hostShapes()[k - clouds_] = *plainShape(*pair.shape()->shape, toShapeOf(cloud, *pair.shape()),
                                            cloud.field->cloud().voxelSize());
  }
  for (std::size_t side = 0; side < 2; ++side) {
    const Offsets& offsets = offsets_[2 * k + side];
    CcDirection& d = hostPairs_[k].ways[side];
    const ContactBody &own = side == 0 ? *pair.a : *pair.b, &other = side == 0 ? *pair.b : *pair.a;
    if (own.field) d.way = wayOf(own, other, pair.frame);
    d.own = pair.fields[side];
    d.other = pair.fields[1 - side];
    d.hits = offsets.hits;
    d.room = pair.room;
    for (std::size_t i = 0; i < 2; ++i) d.nearby[i] = offsets.nearby[i];
  }
}

void OpenClBatch::send(BatchReport& report) {
  const std::size_t all = count_ * sizeof(CcPair);
  queue_.enqueueWriteBuffer(pairs_.reserve(*device_, all), CL_FALSE, 0, all, sent_.data(), nullptr,
                            device_->note("poses sent"));
  report.sent += all;
  const std::size_t ofShapes = shapes() * sizeof(CcShape);
  shapes_.reserve(*device_, std::max(ofShapes, sizeof(CcShape)));
  if (ofShapes == 0) return;
  queue_.enqueueWriteBuffer(shapes_.buffer(), CL_FALSE, 0, ofShapes, hostShapes(), nullptr,
                            device_->note("poses sent"));
  report.sent += ofShapes;
}

void OpenClBatch::reserveResults() {
  const auto n = static_cast<std::uint32_t>(count_);
  binRoom_ = std::max({binRoom_, kMinRoom, n * kBins, neededBins_ + neededBins_ / 4});
  patchRoom_ = std::max({patchRoom_, kMinRoom, n * kPatches, neededPatches_ + neededPatches_ / 4});
  contactsBegin_ = contactsAfter(count_) * sizeof(CcContactPatch);
  results_.reserve(*device_, contactsBegin_ + patchRoom_ * sizeof(CcContactPatch));
}

void OpenClBatch::searchLevels() {
  Device& d = *device_;
  const std::size_t hits = std::max<std::size_t>(hitRoom_, 1), items = 2 * clouds_ * CC_GROUP,
                    itemsOfShapes = shapes() * CC_GROUP;
  const cl::Buffer &data = fields_->data(), &fields = fields_->table(), &pairs = pairs_.buffer(),
                   &results = results_.buffer();
  const cl::Buffer& found = found_.reserve(d, 2 * count_ * kLevels * sizeof(CcFound));
  const cl::Buffer& nearby =
      nearby_.reserve(d, std::max<std::size_t>(nearbyRoom_, 1) * sizeof(cl_uint));
  const cl::Buffer& aside = aside_.reserve(d, hits * 3 * sizeof(cl_uint));
  const cl::Buffer& hitBuffer = hits_.reserve(d, hits * kHitBytes);
  const cl::Buffer& keys = keys_.reserve(d, hits * sizeof(cl_ulong));
  static constexpr const char *kSearch[kLevels] = {"ccSearch 0", "ccSearch 1", "ccSearch 2"},
                              *kHits[kLevels] = {"ccHits 0", "ccHits 1", "ccHits 2"};
  const auto first = static_cast<cl_uint>(clouds_);
  for (cl_int level = kLevels - 1; level >= finest_; --level) {
    const cl_int last = level == finest_;
    if (clouds_ > 0 && finest_ == kLevels - 1)
      run({"ccSearchCoarsest", items, CC_GROUP, kSearch[level]}, fields, data, data, data, data,
          data, pairs, found, nearby, aside, results);
    else if (clouds_ > 0)
      run({"ccSearch", items, CC_GROUP, kSearch[level]}, level, last, fields, data, data, data,
          data, data, pairs, found, nearby, aside, results);
    if (clouds_ > 0 && level == kLevels - 1)
      run({"ccHitsCoarsest", items, CC_GROUP, kHits[level]}, fields, data, data, data, data, data,
          pairs, found, hitBuffer, keys, aside);
    else if (clouds_ > 0)
      run({"ccHits", items, CC_GROUP, kHits[level]}, level, fields, data, data, data, data, data,
          pairs, found, hitBuffer, keys, aside);
    if (shapes() == 0) continue;
    run({"ccSearchShapes", itemsOfShapes, CC_GROUP}, level, last, first, fields, data, data, data,
        data, data, pairs, shapes_.buffer(), found, nearby, aside, results);
    run({"ccHitsInShapes", itemsOfShapes, CC_GROUP}, level, first, fields, data, data, data, data,
        data, pairs, shapes_.buffer(), found, hitBuffer, keys, aside);
  }
}

void OpenClBatch::growPatches() {
  Device& d = *device_;
  const std::size_t hits = std::max<std::size_t>(hitRoom_, 1);
  const cl::Buffer &pairs = pairs_.buffer(), &results = results_.buffer(), &found = found_.buffer(),
                   &hitBuffer = hits_.buffer();
  const cl::Buffer& order = order_.reserve(d, hits * sizeof(cl_uint));
  const cl::Buffer& bins = bins_.reserve(d, binRoom_ * sizeof(CcBin));
  const cl::Buffer& sums = sums_.reserve(d, binRoom_ * sizeof(CcSums));
  const cl::Buffer& sprouts = sprouts_.reserve(d, binRoom_ * sizeof(CcSprout));
  const cl::Buffer& queues = queues_.reserve(d, binRoom_ * sizeof(cl_uint));
  const cl::Buffer& grown = grown_.reserve(d, patchRoom_ * sizeof(CcGrown));
  run({"ccBins", count_ * CC_GROUP, CC_GROUP}, pairs, found, hitBuffer, keys_.buffer(),
      slots_.reserve(d, hits * sizeof(cl_uint)), order, results, bins, binRoom_, finest_);
  run({"ccSums", count_ * CC_TEAMS_A_PAIR * CC_TEAM, CC_TEAM}, pairs, found, results, hitBuffer,
      order, bins, sums);
  const cl::Buffer& heaviest = heaviest_.reserve(d, binRoom_ * sizeof(cl_ushort));
  const cl::Buffer& around = around_.reserve(d, binRoom_ * CC_NEIGHBORS * sizeof(cl_ushort));
  const cl::Buffer& neighbors = neighbors_.reserve(d, binRoom_);
  run({"ccSprouts", count_ * CC_GROUP, CC_GROUP}, pairs, results, bins, sums, sprouts, heaviest,
      around, neighbors);
  run({"ccGrow", count_ * CC_TEAM, CC_TEAM}, results, sprouts, neighbors, heaviest, around, queues,
      scratch_.reserve(d, binRoom_ * sizeof(CcGrown)), grown, patchRoom_);
  const cl::Buffer& patches = patches_.reserve(d, patchRoom_ * sizeof(CcSums));
  run({"ccPatches", std::min(kMaxItems, std::size_t{CC_TEAM} * patchRoom_), CC_TEAM, nullptr,
       &patchesDone_},
      sums, queues, grown, results, patchRoom_, patches);
  makePoints(bins, grown, patches);
}

void OpenClBatch::makePoints(const cl::Buffer& bins, const cl::Buffer& grown,
                             const cl::Buffer& patches) {
  Device& d = *device_;
  const std::size_t hits = std::max<std::size_t>(hitRoom_, 1);
  const std::size_t teams = std::min(kMaxItems, std::size_t{CC_TEAM} * patchRoom_),
                    items = (patchRoom_ + CC_TEAM - 1) / CC_TEAM * CC_TEAM;
  const cl::Buffer &pairs = pairs_.buffer(), &results = results_.buffer(),
                   &queues = queues_.buffer(), &hitBuffer = hits_.buffer();
  const cl::Buffer& forces = forces_.reserve(d, patchRoom_ * sizeof(CcPatchForce));
  const cl::Buffer& wholes = wholes_.reserve(d, count_ * sizeof(CcWhole));
  const cl::Buffer& listed = listed_.reserve(d, patchRoom_ * sizeof(CcListed));
  const cl::Buffer& placed = placed_.reserve(d, patchRoom_ * sizeof(CcPlaced));
  const cl::Buffer& places = places_.reserve(d, hits * sizeof(cl_float4));
  const cl::Buffer& facing = facing_.reserve(d, hits * sizeof(CcFacing));
  const auto contactsAt = static_cast<cl_uint>(contactsBegin_ / sizeof(CcContactPatch));
  const auto findNearest = [&](cl_int round) {
    static constexpr const char* kRounds[] = {"ccNearest 0", "ccNearest 1", "ccNearest 2"};
    static_assert(std::size(kRounds) == CC_WET_ROUNDS + 1);
    run({"ccNearest", teams, CC_TEAM, kRounds[round]}, results, listed, queues, grown, bins, places,
        facing, placed, round);
  };
  run({"ccForces", count_ * CC_TEAM, CC_TEAM}, pairs, results, patches, forces, wholes, listed,
      fields_->table(), fields_->data(), fields_->data(), found_.buffer(), hitBuffer,
      shapes_.buffer(), static_cast<cl_uint>(clouds_));
  run({"ccLineUp", std::min(kMaxItems, CC_LINING_UP * teams), CC_TEAM}, pairs, results, listed,
      queues, grown, bins, hitBuffer, order_.buffer(), places, facing);
  run({"ccPlans", items, CC_TEAM}, pairs, results, patches, forces, listed, placed);
  for (cl_int round = 0; round < CC_WET_ROUNDS; ++round) {
    findNearest(round);
    run({"ccMovePlaces", items, CC_TEAM}, results, patches, forces, listed, placed);
  }
  findNearest(CC_WET_ROUNDS);
  run({"ccContacts", items, CC_TEAM}, pairs, results, patches, forces, wholes, listed, placed,
      results, contactsAt);
  run({"ccLevels", count_ * CC_TEAM, CC_TEAM}, pairs, results, wholes, results, contactsAt);
}

// Reads as many contacts as the last batch had and a few more. finish() reads the rest once their
// number is known.
void OpenClBatch::fetch() {
  Device& d = *device_;
  fetchedContacts_ = std::min(neededContacts_ + neededContacts_ / 16, patchRoom_);
  const std::size_t all = contactsBegin_ + fetchedContacts_ * sizeof(CcContactPatch);
  auto* const to = static_cast<unsigned char*>(
      fetched_.reserve(d, contactsBegin_ + patchRoom_ * sizeof(CcContactPatch)));
  queue_.enqueueReadBuffer(results_.buffer(), CL_FALSE, 0, all, to, nullptr, &fetchDone_);
  if (cl::Event* const noted = d.note("contacts fetched")) *noted = fetchDone_;
  queue_.flush();
  hostResults_ = reinterpret_cast<const CcResults*>(to);
  hostContacts_ = reinterpret_cast<const CcContactPatch*>(to + contactsBegin_);
}

// After a failure, waits for the commands that still use the buffers.
template <typename Work>
void OpenClBatch::enqueue(Work&& work) {
  try {
    guardedForRoom(device_->name(), [&] { settled(queue_, work); });
  } catch (const std::bad_alloc&) {
    release();
    throw;
  }
}

void OpenClBatch::search(BatchReport& report) {
  enqueue([&] {
    send(report);
    reserveResults();
    searchLevels();
  });
}

void OpenClBatch::makeContacts() {
  enqueue([&] {
    growPatches();
    fetch();
  });
}

void OpenClBatch::finishQuietly() {
  ::clFinish(queue_());
}

// Polls a GPU, because a sleeping thread wakes late. A CPU needs the thread for the kernels.
void OpenClBatch::wait(const cl::Event& event) {
  while (device_->gpu() && event.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() > CL_COMPLETE)
    std::this_thread::yield();
  event.wait();
}

void OpenClBatch::waitForPatches() {
  guarded(device_->name(), [&] { wait(patchesDone_); });
}

void OpenClBatch::finish(BatchReport& report) {
  guarded(device_->name(), [&] { wait(fetchDone_); });
  neededBins_ = hostResults_->counters[CC_BINS];
  neededPatches_ = hostResults_->counters[CC_PATCHES];
  neededContacts_ = hostResults_->counters[CC_CONTACTS];
  if (neededContacts_ > fetchedContacts_)
    guarded(device_->name(), [&] {
      const std::size_t begin = contactsBegin_ + fetchedContacts_ * sizeof(CcContactPatch);
      queue_.enqueueReadBuffer(results_.buffer(), CL_TRUE, begin,
                               contactsBegin_ + neededContacts_ * sizeof(CcContactPatch) - begin,
                               static_cast<unsigned char*>(fetched_.data()) + begin, nullptr,
                               device_->note("contacts fetched"));
    });
  report.fetched +=
      contactsBegin_ + std::max(neededContacts_, fetchedContacts_) * sizeof(CcContactPatch);
  report.bins += neededBins_;
  report.patches += std::min(neededPatches_, patchRoom_);
  report.contacts += neededContacts_;
}

void OpenClBatch::setFinest(int level) {
  finest_ = std::min(level, lastFinest_);
  lastFinest_ = level;
}

std::span<const CcContactPatch> OpenClBatch::contacts(std::size_t k) const {
  return {hostContacts_ + answer(k).firstPatch, answer(k).patches};
}

}  // namespace cloudcontact::opencl
