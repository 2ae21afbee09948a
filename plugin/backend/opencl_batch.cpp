// One upload, one chain of kernels, one download.
#include "opencl_batch.h"

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

const FieldData& dataOf(const ContactBody& body) {
  return static_cast<const FieldData&>(*body.field);
}

}  // namespace

cl::Kernel& OpenClBatch::kernel(const char* name) {
  const auto known = kernels_.find(name);
  if (known != kernels_.end()) return known->second;
  return kernels_.emplace(name, device_->another(name)).first->second;
}

void OpenClBatch::run(const char* name, std::size_t items, std::size_t group) {
  device_->run(queue_, kernel(name), name, items, group);
}

using B = OpenClBatch;
constexpr std::array<Grown OpenClBatch::*, 20> OpenClBatch::kGrown = {
    &B::tasks_, &B::results_, &B::found_,  &B::nearby_, &B::hits_,     &B::aside_,  &B::keys_,
    &B::slots_, &B::order_,   &B::bins_,   &B::sums_,   &B::sprouts_,  &B::queues_, &B::scratch_,
    &B::grown_, &B::patches_, &B::forces_, &B::kept_,   &B::heaviest_, &B::near_};

std::size_t OpenClBatch::bytes() const {
  std::size_t sum = 0;
  for (const auto grown : kGrown) sum += (this->*grown).bytes();
  return sum;
}

// All that a try took: fewer pairs must not find the device filled by it. Kernels hold what they
// were given, and a device may note memory as given that it turns out not to have.
void OpenClBatch::giveBack() {
  kernels_.clear();
  for (cl::Buffer* part : {&directions_, &pairs_, &answersThere_, &counters_, &contacts_})
    *part = cl::Buffer();
  for (const auto grown : kGrown) this->*grown = Grown();
  sent_.giveBack();
  fetched_.giveBack();
}

void OpenClBatch::send(std::span<const Asked> pairs, const Each& each, BatchReport& report) {
  const std::size_t n = pairs.size(), ways = aligned(2 * n * sizeof(CcDirection)),
                    all = ways + n * sizeof(CcPair);
  unsigned char* const to = static_cast<unsigned char*>(sent_.room(*device_, all));
  auto* const directions = reinterpret_cast<CcDirection*>(to);
  auto* const tasks = reinterpret_cast<CcPair*>(to + ways);
  std::size_t hits = 0, nearby = 0;
  for (std::size_t k = 0; k < 2 * n; ++k) {
    const Asked& asked = pairs[k / 2];
    const SampleSet& samples = dataOf(k % 2 == 0 ? asked.pair->a : asked.pair->b).samples();
    CcDirection& d = directions[k];
    d.own = asked.fields[k % 2];
    d.other = asked.fields[1 - k % 2];
    d.hits = static_cast<std::uint32_t>(hits);
    d.room = asked.room;
    hits += d.room;
    for (int level : {2, 1}) {
      d.nearby[level == 1] = static_cast<std::uint32_t>(nearby);
      nearby += samples.levels[level].samples.size();
    }
  }
  if (std::max(hits, nearby) > std::numeric_limits<std::uint32_t>::max() / 4)
    throw std::bad_alloc();
  each(n, [&](std::size_t k) {
    const BatchPair& pair = *pairs[k].pair;
    tasks[k] = pairOf(pairs[k]);
    directions[2 * k].way = wayOf(pair.a, pair.b, pairs[k].frame);
    directions[2 * k + 1].way = wayOf(pair.b, pair.a, pairs[k].frame);
  });
  hitRoom_ = hits;
  nearbyRoom_ = nearby;
  queue_.enqueueWriteBuffer(tasks_.room(*device_, all), CL_FALSE, 0, all, to, nullptr,
                            device_->note("poses sent"));
  directions_ = tasks_.part(0, ways);
  pairs_ = tasks_.part(ways, n * sizeof(CcPair));
  report.sent += all;
}

// Where what is fetched goes: answers and counters, then contacts.
void OpenClBatch::makeRoom() {
  const auto n = static_cast<std::uint32_t>(count_);
  binRoom_ = std::max({kLeastRoom, n * kBins, binsWanted_ + binsWanted_ / 4});
  patchRoom_ = std::max({kLeastRoom, n * kPatches, patchesWanted_ + patchesWanted_ / 4});
  const std::size_t counters = aligned(count_ * sizeof(CcAnswer));
  contactsBegin_ = counters + aligned(CC_COUNTERS * sizeof(cl_uint));
  results_.room(*device_, contactsBegin_ + patchRoom_ * sizeof(CcContactPatch));
  answersThere_ = results_.part(0, counters);
  counters_ = results_.part(counters, CC_COUNTERS * sizeof(cl_uint));
  contacts_ = results_.part(contactsBegin_, patchRoom_ * sizeof(CcContactPatch));
}

void OpenClBatch::search() {
  Device& d = *device_;
  const std::size_t hits = std::max<std::size_t>(hitRoom_, 1);
  const cl::Buffer& data = fields_->data();
  cl::Kernel& search = kernel("ccSearch");
  give(search, cl_int{0}, fields_->table(), data, data, data, data, data, pairs_, directions_,
       found_.room(d, 2 * count_ * kLevels * sizeof(CcFound)),
       nearby_.room(d, std::max<std::size_t>(nearbyRoom_, 1) * sizeof(cl_uint)),
       aside_.room(d, hits * 3 * sizeof(cl_uint)), counters_);
  cl::Kernel& taken = kernel("ccHits");
  give(taken, cl_int{0}, fields_->table(), data, data, data, data, data, pairs_, directions_,
       found_.buffer(), hits_.room(d, hits * kHitBytes), keys_.room(d, hits * sizeof(cl_ulong)),
       aside_.buffer());
  static constexpr const char *kNames[kLevels] = {"ccSearch 0", "ccSearch 1", "ccSearch 2"},
                              *kTaken[kLevels] = {"ccHits 0", "ccHits 1", "ccHits 2"};
  for (cl_int level = kLevels - 1; level >= finest_; --level) {
    search.setArg(0, level);
    d.run(queue_, search, kNames[level], 2 * count_ * CC_GROUP, CC_GROUP);
    taken.setArg(0, level);
    d.run(queue_, taken, kTaken[level], 2 * count_ * CC_GROUP, CC_GROUP);
  }
}

void OpenClBatch::gather() {
  Device& d = *device_;
  const std::size_t hits = std::max<std::size_t>(hitRoom_, 1);
  const cl::Buffer &pairs = pairs_, &directions = directions_, &counters = counters_,
                   &answers = answersThere_, &found = found_.buffer(), &hitsThere = hits_.buffer();
  const cl::Buffer& order = order_.room(d, hits * sizeof(cl_uint));
  const cl::Buffer& bins = bins_.room(d, binRoom_ * sizeof(CcBin));
  const cl::Buffer& sums = sums_.room(d, binRoom_ * sizeof(CcSums));
  const cl::Buffer& sprouts = sprouts_.room(d, binRoom_ * sizeof(CcSprout));
  const cl::Buffer& queues = queues_.room(d, binRoom_ * sizeof(cl_uint));
  const cl::Buffer& grown = grown_.room(d, patchRoom_ * sizeof(CcGrown));
  give(kernel("ccBins"), pairs, directions, found, hitsThere, keys_.buffer(),
       slots_.room(d, hits * sizeof(cl_uint)), order, answers, bins, counters, binRoom_, finest_);
  run("ccBins", count_ * CC_GROUP, CC_GROUP);
  give(kernel("ccSums"), pairs, directions, found, answers, hitsThere, order, bins, sums);
  run("ccSums", count_ * CC_TEAMS_A_PAIR * CC_TEAM, CC_TEAM);
  const cl::Buffer& heaviest = heaviest_.room(d, binRoom_ * sizeof(cl_ushort));
  const cl::Buffer& near = near_.room(d, binRoom_ * CC_NEIGHBOURS * sizeof(cl_uint));
  give(kernel("ccSprouts"), pairs, answers, bins, sums, sprouts, heaviest, near);
  run("ccSprouts", count_ * CC_GROUP, CC_GROUP);
  give(kernel("ccGrow"), answers, sprouts, heaviest, near, queues,
       scratch_.room(d, binRoom_ * sizeof(CcGrown)), grown, counters, patchRoom_);
  run("ccGrow", count_ * CC_TEAM, CC_TEAM);
  const cl::Buffer& patches = patches_.room(d, patchRoom_ * sizeof(CcSums));
  give(kernel("ccPatches"), sums, queues, grown, counters, patchRoom_, patches);
  device_->run(queue_, kernel("ccPatches"), "ccPatches",
               std::min(kMostItems, std::size_t{CC_TEAM} * patchRoom_), CC_TEAM, &grownAll_);
  give(kernel("ccContacts"), pairs, answers, patches,
       forces_.room(d, patchRoom_ * sizeof(CcPatchForce)),
       kept_.room(d, patchRoom_ * sizeof(cl_uint)), contacts_, counters);
  run("ccContacts", count_ * CC_TEAM, CC_TEAM);
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

void OpenClBatch::start(std::span<const Asked> pairs, const Each& each, BatchReport& report) {
  count_ = pairs.size();
  try {
    guardedForRoom(device_->name(), [&] {
      // What is under way where it fails still reads what the next call will write.
      settled(queue_, [&] {
        send(pairs, each, report);
        makeRoom();
        search();
        gather();
        fetch();
      });
    });
  } catch (const std::bad_alloc&) {
    giveBack();
    throw;
  }
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
  int finest = kLevels - 1;
  for (std::size_t k = 0; k < count_; ++k) {
    report.asked += answers_[k].asked;
    report.hits += answers_[k].hits;
    finest = std::min(finest, answers_[k].failed & CC_FINER ? 0 : answers_[k].level);
  }
  finest_ = std::min(finest, finestBefore_);
  finestBefore_ = finest;
}

std::span<const CcContactPatch> OpenClBatch::contacts(std::size_t k) const {
  return {contactsHere_ + answers_[k].firstPatch, answers_[k].patches};
}

}  // namespace cloudcontact::opencl
