// DeviceSearch: decides which pairs go to the device, and runs them in parts.
#include "device/device_search.h"

#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/device/device_list.h>

#include <stdexcept>

#include "contact/contact_builder.h"
#include "law/kernel_solid.h"

#if defined(CLOUDCONTACT_OPENCL)

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/partitioner.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <new>
#include <vector>

#include "device/opencl_batch.h"

namespace cloudcontact {

namespace {

// Parts of a batch, each in its own queue, and pairs that make another part worthwhile.
constexpr std::size_t kParts = 2, kPairsPerPart = 32;
// Hits that a direction may store: the factor if that was too few, and at most.
constexpr std::uint32_t kRoomFactor = 4, kMaxRoom = 1u << 20;

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

struct DeviceSearch::State {
  BatchSettings settings;
  tbb::task_arena arena;
  BatchReport report;
  std::shared_ptr<opencl::Device> device;
  std::shared_ptr<opencl::DeviceFields> fields;
  // Some of the device's pairs, in a queue of their own.
  struct Part {
    opencl::OpenClBatch batch;
    std::size_t first = 0, count = 0;  // in devicePairs
    BatchReport report;

    Part(const std::shared_ptr<opencl::Device>& device,
         const std::shared_ptr<opencl::DeviceFields>& fields)
        : batch(device, fields) {}
  };
  std::deque<Part> parts;
  std::vector<opencl::DevicePair> devicePairs;
  std::vector<SearchTask*> deviceTasks;  // of devicePairs

  explicit State(const BatchSettings& given);
  void take(std::span<SearchTask> tasks);
  void runParts(const std::function<void()>& meanwhile);
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
  // Why the device has no contact of the i-th pair of a part; 0 if it has one, or there is none.
  int failedOf(const Part& part, std::size_t i) const {
    const CcAnswer& answer = part.batch.answer(i);
    const bool pressesNothing = answer.hits > 0 && answer.patches == 0;
    return answer.failed ? answer.failed : pressesNothing ? CC_NO_TOUCH : 0;
  }
  void readAnswers(Part& part);
  void readAnswer(Part& part, std::size_t i, Totals& totals);

  // For items that take equally long. Each thread gets the same pairs in every step, whose data is
  // in its cache (docs/tried.md).
  template <typename Function>
  void eachAlike(std::size_t count, const Function& function) {
    arena.execute([&] {
      // A thread that waits here must not start other work of the caller's.
      tbb::this_task_arena::isolate(
          [&] { tbb::parallel_for(std::size_t{0}, count, function, tbb::static_partitioner{}); });
    });
  }
};

DeviceSearch::State::State(const BatchSettings& given)
    : settings(given),
      arena(given.threads > 0 ? given.threads : tbb::task_arena::automatic),
      device(opencl::Device::open(given.timing)),
      fields(std::make_shared<opencl::DeviceFields>(device)) {
  for (std::size_t k = 0; k < kParts; ++k) parts.emplace_back(device, fields);
}

// Lists the tasks that the device may answer: first those of two clouds, as OpenClBatch has it.
void DeviceSearch::State::take(std::span<SearchTask> tasks) {
  devicePairs.clear();
  deviceTasks.clear();
  // Neighbors in the list mostly have the same fields, so the last lookup is remembered.
  const SurfaceField* lastField[2] = {nullptr, nullptr};
  std::uint32_t lastIndex[2] = {0, 0};
  const auto findField = [&](const ContactBody& body, int side) {
    if (body.field == lastField[side]) return;
    lastField[side] = body.field;
    lastIndex[side] =
        opencl::guarded(device->name(), [&] { return fields->indexOf(body.field->data()); });
  };
  const auto add = [&](SearchTask& task) {
    const bool shapes = task.a->shape || task.b->shape;
    if (shapes || !task.a->field || !task.b->field)  // throws the right message
      task.finder->builder().begin(*task.a, *task.b, *task.settings, *task.found);
    findField(task.a->field ? *task.a : *task.b, 0);
    findField(task.b->field ? *task.b : *task.a, 1);
    devicePairs.push_back(
        {task.a, task.b, task.settings, {}, *task.room, {lastIndex[0], lastIndex[1]}});
    deviceTasks.push_back(&task);
  };
  for (const bool shapes : {false, true})
    for (SearchTask& task : tasks) {
      if ((task.a->shape || task.b->shape) != shapes) continue;
      task.answered = false;
      if (takes(task))
        add(task);
      else
        ++report.shapes;
    }
  opencl::guarded(device->name(), [&] { fields->sendTable(); });
}

// In two parts the CPU prepares and reads some pairs while the device works on others. All searches
// are enqueued first, so that the device never waits for the host (docs/tried.md).
void DeviceSearch::State::runParts(const std::function<void()>& meanwhile) {
  const std::size_t n = devicePairs.size(),
                    most = settings.timing ? 1 : kParts,  // timed kernels run alone
      used = std::clamp(n / kPairsPerPart, std::size_t{1}, most);
  bool fit[kParts] = {};
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
  if (meanwhile) meanwhile();
  for (std::size_t k = 0; k < used; ++k) {
    if (fit[k])
      finish(parts[k]);
    else
      runHalves(parts[k], parts[k].first, parts[k].count);
  }
  for (std::size_t k = 0; k < used; ++k) report += parts[k].report;
}

// The work before the device; `reserved`: the part has an upload buffer.
void DeviceSearch::State::prepare(Part& part, bool reserved) {
  eachAlike(part.count, [&](std::size_t i) {
    opencl::DevicePair& pair = devicePairs[part.first + i];
    const SearchTask& task = *deviceTasks[part.first + i];
    pair.frame = task.finder->builder().begin(*pair.a, *pair.b, *pair.settings, *task.found);
    if (reserved) part.batch.writePose(i);
  });
}

// Runs prepared pairs; returns whether they fit in device memory.
bool DeviceSearch::State::run(Part& part) {
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
void DeviceSearch::State::wakeThreads(std::size_t pairs) {
  const auto threads = static_cast<std::size_t>(arena.max_concurrency());
  for (std::size_t k = 1; k < std::min(threads, pairs); ++k) arena.enqueue([] {});
}

// Threads sleep while the device works. They are woken during its last kernels.
void DeviceSearch::State::finish(Part& part) {
  part.batch.waitForPatches();
  eachAlike(static_cast<std::size_t>(arena.max_concurrency()), [](std::size_t) {});
  part.batch.finish(part.report);
  readAnswers(part);
}

void DeviceSearch::State::runHalves(Part& part, std::size_t first, std::size_t count) {
  if (count == 0) return;
  if (count == 1) {
    ++part.report.noRoom;
    return;
  }
  for (const bool second : {false, true}) {
    part.first = second ? first + count / 2 : first;
    part.count = second ? count - count / 2 : count / 2;
    if (!run(part)) runHalves(part, part.first, part.count);
  }
}

void DeviceSearch::State::readAnswers(Part& part) {
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
  part.report.onDevice += part.count - failed;
  part.batch.setFinest(finest);
  for (std::size_t i = 0; i < (failed > 0 ? part.count : 0); ++i) {
    const int why = failedOf(part, i);
    if (!why) continue;
    ++(why & CC_FINER        ? part.report.finer
       : why & CC_NO_TOUCH   ? part.report.nearMisses
       : why & CC_SHAPE_EDGE ? part.report.shapes
                             : part.report.noRoom);
  }
}

// Reads a pair's contacts, and how many hits it may store in the next step.
void DeviceSearch::State::readAnswer(Part& part, std::size_t i, Totals& totals) {
  const CcAnswer& answer = part.batch.answer(i);
  SearchTask& task = *deviceTasks[part.first + i];
  // If there was no room, `needed` is not the full count.
  const std::uint32_t room = answer.failed & CC_NO_ROOM
                                 ? std::max(kRoomFactor * *task.room, 2 * answer.needed)
                                 : std::max(*task.room, answer.needed + answer.needed / 4);
  *task.room = std::min(room, kMaxRoom);
  totals.samples += answer.lookups;
  totals.hits += answer.hits;
  totals.finest = std::min(totals.finest, answer.failed & CC_FINER ? 0 : answer.level);
  const bool failed = failedOf(part, i) != 0;
  totals.failed += failed;
  if (failed) return;
  task.found->samples = answer.hits;
  task.found->level = answer.level;
  for (const CcContactPatch& contact : part.batch.contacts(i))
    task.finder->builder().add(contact, *task.found);
  if (task.named) task.finder->giveIds(*task.found);
  task.answered = true;
}

DeviceSearch::DeviceSearch(const BatchSettings& settings)
    : state_(std::make_unique<State>(settings)) {}

const std::string& DeviceSearch::device() const {
  return state_->device->name();
}

void DeviceSearch::run(std::span<SearchTask> tasks, const std::function<void()>& meanwhile) {
  State& s = *state_;
  s.report = {};
  for (State::Part& part : s.parts) part.report = {};  // left by a call that threw
  try {
    s.wakeThreads(tasks.size());
    s.take(tasks);
    s.runParts(meanwhile);
  } catch (...) {
    // The next call uses the same buffers.
    for (State::Part& part : s.parts) part.batch.finishQuietly();
    for (SearchTask& task : tasks) task.answered = false;
    throw;
  }
}

const BatchReport& DeviceSearch::report() const {
  return state_->report;
}

std::size_t DeviceSearch::bytes() const {
  std::size_t sum = state_->fields->bytes();
  for (const State::Part& part : state_->parts) sum += part.batch.bytes();
  return sum;
}

std::map<std::string, DeviceTime> DeviceSearch::deviceTimes() {
  return state_->device->clock();
}

}  // namespace cloudcontact

#else

namespace cloudcontact {

std::vector<std::string> openClDevices() {
  return {};
}

struct DeviceSearch::State {};

DeviceSearch::DeviceSearch(const BatchSettings&) {
  throw std::runtime_error(
      "built without OpenCL; install ocl-icd-opencl-dev and opencl-clhpp-headers and build again");
}

// None of these is reached, as there is no such object.
const std::string& DeviceSearch::device() const {
  static const std::string none;
  return none;
}
void DeviceSearch::run(std::span<SearchTask>, const std::function<void()>&) {}
const BatchReport& DeviceSearch::report() const {
  static const BatchReport none;
  return none;
}
std::size_t DeviceSearch::bytes() const {
  return 0;
}
std::map<std::string, DeviceTime> DeviceSearch::deviceTimes() {
  return {};
}

}  // namespace cloudcontact

#endif

namespace cloudcontact {

DeviceSearch::~DeviceSearch() = default;

bool DeviceSearch::takes(const SearchTask& task) {
  const auto has = [](const ContactBody& body) { return !body.shape || plainSolid(*body.shape); };
  return !task.apart && has(*task.a) && has(*task.b) && !(task.a->shape && task.b->shape) &&
         !TouchedMatter::wanted(*task.a, *task.b);
}

BatchReport& BatchReport::operator+=(const BatchReport& other) {
  for (std::size_t BatchReport::*number :
       {&BatchReport::onDevice, &BatchReport::onCpu, &BatchReport::noRoom, &BatchReport::finer,
        &BatchReport::nearMisses, &BatchReport::shapes, &BatchReport::samples, &BatchReport::hits,
        &BatchReport::bins, &BatchReport::patches, &BatchReport::contacts, &BatchReport::sent,
        &BatchReport::fetched})
    this->*number += other.*number;
  return *this;
}

}  // namespace cloudcontact
