// ContactBatch: decides which pairs go to the device, and solves the others on the CPU.
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/device/contact_batch.h>

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/partitioner.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <new>
#include <optional>
#include <stdexcept>

#include "contact/contact_builder.h"

#if defined(CLOUDCONTACT_OPENCL)
#include "device/opencl_batch.h"
#endif

namespace cloudcontact {

namespace {

// Parts of a batch, each in its own queue, and pairs that make another part worthwhile.
constexpr std::size_t kParts = 2, kPairsPerPart = 32;
// Hits that a direction may store: at first, the factor if that was too few, and at most.
constexpr std::uint32_t kFirstRoom = 2048, kRoomFactor = 4, kMaxRoom = 1u << 20;

// Whether the device has the memory for some work.
template <typename Work>
bool fits(Work&& work) {
  try {
    work();
    return true;
  } catch (const std::bad_alloc&) {
    return false;
  }
}

}  // namespace

struct ContactBatch::State {
  BatchSettings settings;
  std::string message, name;
  tbb::task_arena arena;
  std::shared_ptr<ContactWorkspace> workspace = std::make_shared<ContactWorkspace>();
  std::deque<ContactFinder> finders;
  std::vector<std::uint32_t> rooms;  // hits that a direction of each pair may store
  std::vector<const ContactResult*> results;
  std::vector<std::size_t> cpuPairs;
  BatchReport report;
#if defined(CLOUDCONTACT_OPENCL)
  std::shared_ptr<opencl::Device> device;
  std::shared_ptr<opencl::DeviceFields> fields;
  // Some of the device's pairs, in a queue of their own.
  struct Part {
    opencl::OpenClBatch batch;
    std::size_t first = 0, count = 0;   // in devicePairs
    std::vector<std::size_t> cpuPairs;  // that the device did not solve
    BatchReport report;

    Part(const std::shared_ptr<opencl::Device>& device,
         const std::shared_ptr<opencl::DeviceFields>& fields)
        : batch(device, fields) {}
  };
  std::deque<Part> parts;
  std::vector<opencl::DevicePair> devicePairs;
  std::vector<std::size_t> indices;  // of devicePairs in the batch

  void open();
  void runOnDevice(std::span<const BatchPair> pairs);
  void runParts();
  void wakeThreads(std::size_t pairs);
  void finish(Part& part);
  void prepare(Part& part, bool reserved);
  bool run(Part& part);
  void runHalves(Part& part, std::size_t first, std::size_t count);
  std::span<const opencl::DevicePair> pairsOf(const Part& part) const {
    return std::span(devicePairs).subspan(part.first, part.count);
  }
  // Sums over some answers.
  struct Totals {
    std::size_t samples = 0, hits = 0, failed = 0;
    int finest = kLevels - 1;
  };
  void readAnswers(Part& part);
  void readAnswer(Part& part, std::size_t i, Totals& totals);
  void addReport(Part& part);
#endif

  explicit State(const BatchSettings& given);
  void runOnCpu(std::span<const BatchPair> pairs);

  template <typename Function, typename Partitioner = tbb::auto_partitioner>
  void each(std::size_t count, const Function& function, const Partitioner& shares = {}) {
    arena.execute([&] {
      // A thread that waits here must not start other work of the caller's.
      tbb::this_task_arena::isolate(
          [&] { tbb::parallel_for(std::size_t{0}, count, function, shares); });
    });
  }
  // For items that take equally long. Each thread gets the same pairs in every step, whose data is
  // in its cache (docs/measurements.md).
  template <typename Function>
  void eachAlike(std::size_t count, const Function& function) {
    each(count, function, tbb::static_partitioner{});
  }
};

ContactBatch::State::State(const BatchSettings& given)
    : settings(given), arena(given.threads > 0 ? given.threads : tbb::task_arena::automatic) {
  if (settings.backend == Backend::Cpu) return;
#if defined(CLOUDCONTACT_OPENCL)
  try {
    open();
    return;
  } catch (const std::runtime_error& e) {
    message = e.what();
  }
#else
  message =
      "built without OpenCL; install ocl-icd-opencl-dev and opencl-clhpp-headers and build again";
#endif
  message = "contacts are found on the CPU: " + message;
  settings.backend = Backend::Cpu;
}

void ContactBatch::State::runOnCpu(std::span<const BatchPair> pairs) {
  each(cpuPairs.size(), [&](std::size_t i) {
    const std::size_t k = cpuPairs[i];
    results[k] = &finders[k].find(pairs[k].a, pairs[k].b, pairs[k].settings);
  });
  workspace->reserve(arena.max_concurrency());
  report.onCpu += cpuPairs.size();
}

#if defined(CLOUDCONTACT_OPENCL)

void ContactBatch::State::open() {
  device = opencl::Device::open(settings.timing);
  fields = std::make_shared<opencl::DeviceFields>(device);
  for (std::size_t k = 0; k < kParts; ++k) parts.emplace_back(device, fields);
  name = device->name();
}

void ContactBatch::State::runOnDevice(std::span<const BatchPair> pairs) {
  wakeThreads(pairs.size());
  devicePairs.clear();
  indices.clear();
  for (Part& part : parts) {  // left by a call that threw
    part.cpuPairs.clear();
    part.report = {};
  }
  // Neighbors in the list mostly have the same fields, so the last lookup is remembered.
  const SurfaceField* lastField[2] = {nullptr, nullptr};
  std::uint32_t lastIndex[2] = {0, 0};
  const auto findField = [&](const ContactBody& body, int side) {
    if (body.field == lastField[side]) return;
    lastField[side] = body.field;
    lastIndex[side] = opencl::guarded(name, [&] { return fields->indexOf(body.field->data()); });
  };
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const BatchPair& pair = pairs[k];
    if (pair.a.shape || pair.b.shape || TouchedMatter::wanted(pair.a, pair.b, pair.settings)) {
      cpuPairs.push_back(k);
      ++report.shapes;
      continue;
    }
    if (!pair.a.field || !pair.b.field)  // throws the right message
      finders[k].builder().begin(pair.a, pair.b, pair.settings);
    findField(pair.a, 0);
    findField(pair.b, 1);
    devicePairs.push_back(
        {&pair.a, &pair.b, &pair.settings, {}, rooms[k], {lastIndex[0], lastIndex[1]}});
    indices.push_back(k);
  }
  opencl::guarded(name, [&] { fields->sendTable(); });
  runParts();
}

// In two parts the CPU prepares and reads some pairs while the device works on others. All searches
// are enqueued first, so that the device never waits for the host (docs/measurements.md).
void ContactBatch::State::runParts() {
  const std::size_t n = devicePairs.size(),
                    most = settings.timing ? 1 : kParts,  // timed kernels run alone
      used = std::clamp(n / kPairsPerPart, std::size_t{1}, most);
  bool fit[kParts] = {};
  try {
    for (std::size_t k = 0; k < used; ++k) {
      Part& part = parts[k];
      part.first = n * k / used;
      part.count = n * (k + 1) / used - part.first;
      fit[k] = part.count > 0 && fits([&] { part.batch.reserve(pairsOf(part)); });
    }
    for (std::size_t k = 0; k < used; ++k) {
      prepare(parts[k], fit[k]);
      fit[k] = fit[k] && fits([&] { parts[k].batch.search(parts[k].report); });
    }
    for (std::size_t k = 0; k < used; ++k)
      fit[k] = fit[k] && fits([&] { parts[k].batch.makeContacts(); });
    for (std::size_t k = 0; k < used; ++k) {
      if (fit[k])
        finish(parts[k]);
      else
        runHalves(parts[k], parts[k].first, parts[k].count);
    }
  } catch (...) {
    // The next call uses the same buffers.
    for (Part& part : parts) part.batch.finishQuietly();
    throw;
  }
  for (std::size_t k = 0; k < used; ++k) addReport(parts[k]);
}

// The work before the device; `reserved`: the part has an upload buffer.
void ContactBatch::State::prepare(Part& part, bool reserved) {
  eachAlike(part.count, [&](std::size_t i) {
    opencl::DevicePair& pair = devicePairs[part.first + i];
    const std::size_t k = indices[part.first + i];
    pair.frame = finders[k].builder().begin(*pair.a, *pair.b, *pair.settings);
    if (reserved) part.batch.writePose(i);
  });
}

// Runs prepared pairs; returns whether they fit in device memory.
bool ContactBatch::State::run(Part& part) {
  if (part.count == 0) return true;
  const bool fit = fits([&] {
    part.batch.reserve(pairsOf(part));
    for (std::size_t k = 0; k < part.count; ++k) part.batch.writePose(k);
    part.batch.search(part.report);
    part.batch.makeContacts();
  });
  if (fit) finish(part);
  return fit;
}

// A sleeping thread takes 50 us to wake, so threads are woken before there is work for them.
void ContactBatch::State::wakeThreads(std::size_t pairs) {
  const auto threads = static_cast<std::size_t>(arena.max_concurrency());
  for (std::size_t k = 1; k < std::min(threads, pairs); ++k) arena.enqueue([] {});
}

// Threads sleep while the device works. They are woken during its last kernels.
void ContactBatch::State::finish(Part& part) {
  part.batch.waitForPatches();
  eachAlike(static_cast<std::size_t>(arena.max_concurrency()), [](std::size_t) {});
  part.batch.finish(part.report);
  readAnswers(part);
}

void ContactBatch::State::runHalves(Part& part, std::size_t first, std::size_t count) {
  if (count == 1) {
    part.cpuPairs.push_back(indices[first]);
    ++part.report.noRoom;
    return;
  }
  for (const bool second : {false, true}) {
    part.first = second ? first + count / 2 : first;
    part.count = second ? count - count / 2 : count / 2;
    if (!run(part)) runHalves(part, part.first, part.count);
  }
}

void ContactBatch::State::readAnswers(Part& part) {
  std::atomic<std::size_t> samples{0}, hits{0}, failed{0};
  std::atomic<int> finest{kLevels - 1};
  const std::size_t shares =
      std::min(part.count, static_cast<std::size_t>(arena.max_concurrency()));
  eachAlike(shares, [&](std::size_t share) {
    Totals totals;
    const std::size_t end = part.count * (share + 1) / shares;
    for (std::size_t i = part.count * share / shares; i < end; ++i) readAnswer(part, i, totals);
    samples += totals.samples;
    hits += totals.hits;
    failed += totals.failed;
    for (int current = finest; totals.finest < current;)
      if (finest.compare_exchange_weak(current, totals.finest)) break;
  });
  part.report.samples += samples;
  part.report.hits += hits;
  part.batch.setFinest(finest);
  for (std::size_t i = 0; i < (failed > 0 ? part.count : 0); ++i) {
    const int why = part.batch.answer(i).failed;
    if (!why) continue;
    part.cpuPairs.push_back(indices[part.first + i]);
    ++(why & CC_FINER      ? part.report.finer
       : why & CC_NO_TOUCH ? part.report.nearMisses
                           : part.report.noRoom);
  }
}

// Reads a pair's contacts, and how many hits it may store in the next step.
void ContactBatch::State::readAnswer(Part& part, std::size_t i, Totals& totals) {
  const CcAnswer& answer = part.batch.answer(i);
  const std::size_t k = indices[part.first + i];
  // If there was no room, `needed` is not the full count.
  const std::uint32_t room = answer.failed & CC_NO_ROOM
                                 ? std::max(kRoomFactor * rooms[k], 2 * answer.needed)
                                 : std::max(rooms[k], answer.needed + answer.needed / 4);
  rooms[k] = std::min(room, kMaxRoom);
  totals.samples += answer.lookups;
  totals.hits += answer.hits;
  totals.finest = std::min(totals.finest, answer.failed & CC_FINER ? 0 : answer.level);
  totals.failed += answer.failed != 0;
  if (answer.failed) return;
  ContactBuilder& builder = finders[k].builder();
  builder.setHits(answer.hits);
  for (const CcContactPatch& contact : part.batch.contacts(i)) builder.add(contact);
  results[k] = &builder.withIds();
}

void ContactBatch::State::addReport(Part& part) {
  cpuPairs.insert(cpuPairs.end(), part.cpuPairs.begin(), part.cpuPairs.end());
  for (std::size_t BatchReport::*number :
       {&BatchReport::noRoom, &BatchReport::finer, &BatchReport::nearMisses, &BatchReport::samples,
        &BatchReport::hits, &BatchReport::bins, &BatchReport::patches, &BatchReport::contacts,
        &BatchReport::sent, &BatchReport::fetched})
    report.*number += part.report.*number;
  part.cpuPairs.clear();
  part.report = {};
}

#endif

ContactBatch::ContactBatch(const BatchSettings& settings)
    : state_(std::make_unique<State>(settings)) {}
ContactBatch::~ContactBatch() = default;
ContactBatch::ContactBatch(ContactBatch&&) noexcept = default;
ContactBatch& ContactBatch::operator=(ContactBatch&&) noexcept = default;

Backend ContactBatch::backend() const {
  return state_->settings.backend;
}
const std::string& ContactBatch::message() const {
  return state_->message;
}
const std::string& ContactBatch::device() const {
  return state_->name;
}
const BatchReport& ContactBatch::report() const {
  return state_->report;
}

std::span<const ContactResult* const> ContactBatch::find(std::span<const BatchPair> pairs) {
  State& s = *state_;
  s.report = {};
  s.cpuPairs.clear();
  s.results.assign(pairs.size(), nullptr);
  while (s.finders.size() < pairs.size()) s.finders.emplace_back(s.workspace);
  s.rooms.resize(std::max(s.rooms.size(), pairs.size()), kFirstRoom);
#if defined(CLOUDCONTACT_OPENCL)
  if (s.device) {
    s.runOnDevice(pairs);
    s.runOnCpu(pairs);
    s.report.onDevice = pairs.size() - s.cpuPairs.size();
    return s.results;
  }
#endif
  for (std::size_t k = 0; k < pairs.size(); ++k) s.cpuPairs.push_back(k);
  s.runOnCpu(pairs);
  return s.results;
}

std::size_t ContactBatch::deviceBytes() const {
#if defined(CLOUDCONTACT_OPENCL)
  std::size_t sum = state_->fields ? state_->fields->bytes() : 0;
  for (const auto& part : state_->parts) sum += part.batch.bytes();
  return sum;
#else
  return 0;
#endif
}

std::map<std::string, DeviceTime> ContactBatch::deviceTimes() {
#if defined(CLOUDCONTACT_OPENCL)
  if (state_->device) return state_->device->clock();
#endif
  return {};
}

}  // namespace cloudcontact
