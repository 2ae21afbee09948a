// One upload, one chain of kernels, one download.
#include "device/opencl_batch.h"

#include <algorithm>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>

namespace cloudcontact::opencl {

namespace {

// Bins and patches that a pair is first given room for: a M16 thread has 80 and 12.
constexpr std::uint32_t kBins = 128, kPatches = 24;
constexpr std::uint32_t kLeastRoom = 2 * CC_MOST_BINS;  // a large pair alone
constexpr std::size_t kHitBytes = 64;
constexpr std::size_t kMostItems = 4096 * CC_GROUP;  // work-items that take patches in turn

// Of parts of a buffer: a multiple of what devices ask for.
std::size_t aligned(std::size_t size) {
  return (size + 4095) / 4096 * 4096;
}

CcPair pairOf(const Asked& asked) {
  CcPair p{};
  p.terms = termsOf(asked.pair->a, asked.pair->b, asked.pair->settings, asked.frame);
  p.cell = cellOf(asked.frame, 0);
  p.margin = marginOf(asked.pair->settings.margin, asked.frame);
  const std::size_t enough = enoughFor(asked.pair->settings);
  for (int level = 0; level < kLevels; ++level)
    p.enough[level] = static_cast<std::uint32_t>(
        std::min<std::size_t>(neededOf(level, enough), std::numeric_limits<std::uint32_t>::max()));
  return p;
}

}  // namespace

PreparedKernel& OpenClBatch::kernel(const char* name) {
  const auto known = kernels_.find(name);
  if (known != kernels_.end()) return known->second;
  return kernels_.emplace(name, device_->another(name)).first->second;
}

template <typename... Arguments>
void OpenClBatch::run(const Launch& how, const Arguments&... arguments) {
  device_->run(queue_, kernel(how.kernel).give(arguments...), how.noted ? how.noted : how.kernel,
               how.items, how.group, how.done);
}

using B = OpenClBatch;
constexpr std::array<Grown OpenClBatch::*, 21> OpenClBatch::kGrown = {
    &B::tasks_,    &B::results_, &B::found_,     &B::nearby_,  &B::hits_,   &B::aside_,
    &B::keys_,     &B::slots_,   &B::order_,     &B::bins_,    &B::sums_,   &B::sprouts_,
    &B::queues_,   &B::scratch_, &B::grown_,     &B::patches_, &B::forces_, &B::kept_,
    &B::heaviest_, &B::near_,    &B::neighbours_};

std::size_t OpenClBatch::bytes() const {
  std::size_t sum = 0;
  for (const auto grown : kGrown) sum += (this->*grown).bytes();
  return sum;
}

// All that a try took: fewer pairs must not find the device filled by it. Kernels hold what they
// were given, and a device may note memory as given that it turns out not to have.
void OpenClBatch::giveBack() {
  kernels_.clear();
  for (PartOf* part : {&directions_, &pairs_, &answersThere_, &counters_, &contacts_})
    *part = PartOf();
  for (const auto grown : kGrown) this->*grown = Grown();
  binRoom_ = patchRoom_ = 0;
  sent_.giveBack();
  fetched_.giveBack();
}

void OpenClBatch::place(std::span<const Asked> pairs) {
  asked_ = pairs;
  count_ = pairs.size();
  handOver([&] {
    const std::size_t ways = aligned(2 * count_ * sizeof(CcDirection));
    auto* const there =
        static_cast<unsigned char*>(sent_.room(*device_, ways + count_ * sizeof(CcPair)));
    directionsHere_ = reinterpret_cast<CcDirection*>(there);
    pairsHere_ = reinterpret_cast<CcPair*>(there + ways);
    hitRoom_ = nearbyRoom_ = 0;
    places_.resize(2 * count_);
    for (std::size_t k = 0; k < 2 * count_; ++k) {
      const Asked& asked = pairs[k / 2];
      Place& to = places_[k];
      to.hits = static_cast<std::uint32_t>(hitRoom_);
      hitRoom_ += asked.room;
      const std::uint32_t* counts = fields_->counts(asked.fields[k % 2]);
      for (int level : {2, 1}) {
        to.nearby[level == 1] = static_cast<std::uint32_t>(nearbyRoom_);
        nearbyRoom_ += counts[level];
      }
    }
    if (std::max(hitRoom_, nearbyRoom_) > std::numeric_limits<std::uint32_t>::max() / 4)
      throw std::bad_alloc();
  });
}

void OpenClBatch::pose(std::size_t k) {
  const Asked& asked = asked_[k];
  const BatchPair& pair = *asked.pair;
  pairsHere_[k] = pairOf(asked);
  for (std::size_t side = 0; side < 2; ++side) {
    const Place& place = places_[2 * k + side];
    CcDirection& d = directionsHere_[2 * k + side];
    d.way = side == 0 ? wayOf(pair.a, pair.b, asked.frame) : wayOf(pair.b, pair.a, asked.frame);
    d.own = asked.fields[side];
    d.other = asked.fields[1 - side];
    d.hits = place.hits;
    d.room = asked.room;
    for (std::size_t i = 0; i < 2; ++i) d.nearby[i] = place.nearby[i];
  }
}

void OpenClBatch::send(BatchReport& report) {
  const std::size_t ways = aligned(2 * count_ * sizeof(CcDirection)),
                    all = ways + count_ * sizeof(CcPair);
  queue_.enqueueWriteBuffer(tasks_.room(*device_, all), CL_FALSE, 0, all, sent_.data(), nullptr,
                            device_->note("poses sent"));
  directions_.of(tasks_.buffer(), 0, ways);
  pairs_.of(tasks_.buffer(), ways, count_ * sizeof(CcPair));
  report.sent += all;
}

// Where what is fetched goes: answers and counters, then contacts.
void OpenClBatch::makeRoom() {
  const auto n = static_cast<std::uint32_t>(count_);
  binRoom_ = std::max({binRoom_, kLeastRoom, n * kBins, binsWanted_ + binsWanted_ / 4});
  patchRoom_ =
      std::max({patchRoom_, kLeastRoom, n * kPatches, patchesWanted_ + patchesWanted_ / 4});
  const std::size_t counters = aligned(count_ * sizeof(CcAnswer));
  contactsBegin_ = counters + aligned(CC_COUNTERS * sizeof(cl_uint));
  const cl::Buffer& all =
      results_.room(*device_, contactsBegin_ + patchRoom_ * sizeof(CcContactPatch));
  answersThere_.of(all, 0, counters);
  counters_.of(all, counters, CC_COUNTERS * sizeof(cl_uint));
  contacts_.of(all, contactsBegin_, patchRoom_ * sizeof(CcContactPatch));
}

void OpenClBatch::searchLevels() {
  Device& d = *device_;
  const std::size_t hits = std::max<std::size_t>(hitRoom_, 1), items = 2 * count_ * CC_GROUP;
  const cl::Buffer &data = fields_->data(), &fields = fields_->table(), &pairs = pairs_.buffer(),
                   &directions = directions_.buffer(), &counters = counters_.buffer();
  const cl::Buffer& found = found_.room(d, 2 * count_ * kLevels * sizeof(CcFound));
  const cl::Buffer& nearby =
      nearby_.room(d, std::max<std::size_t>(nearbyRoom_, 1) * sizeof(cl_uint));
  const cl::Buffer& aside = aside_.room(d, hits * 3 * sizeof(cl_uint));
  const cl::Buffer& hitsThere = hits_.room(d, hits * kHitBytes);
  const cl::Buffer& keys = keys_.room(d, hits * sizeof(cl_ulong));
  static constexpr const char *kNames[kLevels] = {"ccSearch 0", "ccSearch 1", "ccSearch 2"},
                              *kTaken[kLevels] = {"ccHits 0", "ccHits 1", "ccHits 2"};
  for (cl_int level = kLevels - 1; level >= finest_; --level) {
    run({"ccSearch", items, CC_GROUP, kNames[level]}, level, fields, data, data, data, data, data,
        pairs, directions, found, nearby, aside, counters);
    run({"ccHits", items, CC_GROUP, kTaken[level]}, level, fields, data, data, data, data, data,
        pairs, directions, found, hitsThere, keys, aside);
  }
}

void OpenClBatch::growPatches() {
  Device& d = *device_;
  const std::size_t hits = std::max<std::size_t>(hitRoom_, 1);
  const cl::Buffer &pairs = pairs_.buffer(), &directions = directions_.buffer(),
                   &counters = counters_.buffer(), &answers = answersThere_.buffer(),
                   &found = found_.buffer(), &hitsThere = hits_.buffer();
  const cl::Buffer& order = order_.room(d, hits * sizeof(cl_uint));
  const cl::Buffer& bins = bins_.room(d, binRoom_ * sizeof(CcBin));
  const cl::Buffer& sums = sums_.room(d, binRoom_ * sizeof(CcSums));
  const cl::Buffer& sprouts = sprouts_.room(d, binRoom_ * sizeof(CcSprout));
  const cl::Buffer& queues = queues_.room(d, binRoom_ * sizeof(cl_uint));
  const cl::Buffer& grown = grown_.room(d, patchRoom_ * sizeof(CcGrown));
  run({"ccBins", count_ * CC_GROUP, CC_GROUP}, pairs, directions, found, hitsThere, keys_.buffer(),
      slots_.room(d, hits * sizeof(cl_uint)), order, answers, bins, counters, binRoom_, finest_);
  run({"ccSums", count_ * CC_TEAMS_A_PAIR * CC_TEAM, CC_TEAM}, pairs, directions, found, answers,
      hitsThere, order, bins, sums);
  const cl::Buffer& heaviest = heaviest_.room(d, binRoom_ * sizeof(cl_ushort));
  const cl::Buffer& near = near_.room(d, binRoom_ * CC_NEIGHBOURS * sizeof(cl_ushort));
  const cl::Buffer& neighbours = neighbours_.room(d, binRoom_);
  run({"ccSprouts", count_ * CC_GROUP, CC_GROUP}, pairs, answers, bins, sums, sprouts, heaviest,
      near, neighbours);
  run({"ccGrow", count_ * CC_TEAM, CC_TEAM}, answers, sprouts, neighbours, heaviest, near, queues,
      scratch_.room(d, binRoom_ * sizeof(CcGrown)), grown, counters, patchRoom_);
  const cl::Buffer& patches = patches_.room(d, patchRoom_ * sizeof(CcSums));
  run({"ccPatches", std::min(kMostItems, std::size_t{CC_TEAM} * patchRoom_), CC_TEAM, nullptr,
       &grownAll_},
      sums, queues, grown, counters, patchRoom_, patches);
  run({"ccContacts", count_ * CC_TEAM, CC_TEAM}, pairs, answers, patches,
      forces_.room(d, patchRoom_ * sizeof(CcPatchForce)),
      kept_.room(d, patchRoom_ * sizeof(cl_uint)), contacts_.buffer(), counters);
}

// Reads what there will be by the last batch's number of contacts; the rest, where there are more,
// once it is known.
void OpenClBatch::fetch() {
  Device& d = *device_;
  contactsAsked_ = std::min(contactsWanted_ + contactsWanted_ / 16, patchRoom_);
  const std::size_t all = contactsBegin_ + contactsAsked_ * sizeof(CcContactPatch);
  auto* const to = static_cast<unsigned char*>(
      fetched_.room(d, contactsBegin_ + patchRoom_ * sizeof(CcContactPatch)));
  queue_.enqueueReadBuffer(results_.buffer(), CL_FALSE, 0, all, to, nullptr, &fetchedAll_);
  if (cl::Event* const noted = d.note("contacts fetched")) *noted = fetchedAll_;
  queue_.flush();
  answers_ = reinterpret_cast<const CcAnswer*>(to);
  countersHere_ = reinterpret_cast<const std::uint32_t*>(to + aligned(count_ * sizeof(CcAnswer)));
  contactsHere_ = reinterpret_cast<const CcContactPatch*>(to + contactsBegin_);
}

// What is under way where it fails still reads and writes what the next call will.
template <typename Work>
void OpenClBatch::handOver(Work&& work) {
  try {
    guardedForRoom(device_->name(), [&] { settled(queue_, work); });
  } catch (const std::bad_alloc&) {
    giveBack();
    throw;
  }
}

void OpenClBatch::search(BatchReport& report) {
  handOver([&] {
    send(report);
    makeRoom();
    searchLevels();
  });
}

void OpenClBatch::gather() {
  handOver([&] {
    growPatches();
    fetch();
  });
}

void OpenClBatch::finishQuietly() {
  ::clFinish(queue_());  // the first error is what is told
}

// A thread that sleeps is woken late: a GPU is asked until it is done. Not a CPU, which has the
// kernels to run.
void OpenClBatch::wait(const cl::Event& event) {
  while (device_->gpu() && event.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>() > CL_COMPLETE)
    std::this_thread::yield();
  event.wait();
}

void OpenClBatch::nearEnd() {
  guarded(device_->name(), [&] { wait(grownAll_); });
}

void OpenClBatch::finish(BatchReport& report) {
  guarded(device_->name(), [&] { wait(fetchedAll_); });
  binsWanted_ = countersHere_[CC_BINS];
  patchesWanted_ = countersHere_[CC_PATCHES];
  contactsWanted_ = countersHere_[CC_CONTACTS];
  if (contactsWanted_ > contactsAsked_)
    guarded(device_->name(), [&] {
      const std::size_t begin = contactsBegin_ + contactsAsked_ * sizeof(CcContactPatch);
      queue_.enqueueReadBuffer(results_.buffer(), CL_TRUE, begin,
                               contactsBegin_ + contactsWanted_ * sizeof(CcContactPatch) - begin,
                               static_cast<unsigned char*>(fetched_.data()) + begin, nullptr,
                               device_->note("contacts fetched"));
    });
  report.fetched +=
      contactsBegin_ + std::max(contactsWanted_, contactsAsked_) * sizeof(CcContactPatch);
  report.bins += binsWanted_;
  report.patches += std::min(patchesWanted_, patchRoom_);
  report.contacts += contactsWanted_;
}

void OpenClBatch::learn(int finest) {
  finest_ = std::min(finest, finestBefore_);
  finestBefore_ = finest;
}

std::span<const CcContactPatch> OpenClBatch::contacts(std::size_t k) const {
  return {contactsHere_ + answers_[k].firstPatch, answers_[k].patches};
}

}  // namespace cloudcontact::opencl
