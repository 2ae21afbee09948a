// ContactBatch: the device searches the pairs that it can, the CPU all others.
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/device/contact_batch.h>

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <deque>
#include <stdexcept>
#include <vector>

#include "device/device_search.h"

namespace cloudcontact {

struct ContactBatch::State {
  BatchSettings settings;
  std::string message, name;
  tbb::task_arena arena;
  std::shared_ptr<ContactWorkspace> workspace = std::make_shared<ContactWorkspace>();
  std::deque<ContactFinder> finders;
  std::vector<std::uint32_t> rooms;  // SearchTask::room of each pair
  std::vector<SearchTask> tasks;
  std::deque<ContactResult> found;
  std::vector<const ContactResult*> results;
  BatchReport report;
  std::unique_ptr<DeviceSearch> device;  // null: all pairs on the CPU

  explicit State(const BatchSettings& given);
  void runOnDevice();
  void runOnCpu();
};

ContactBatch::State::State(const BatchSettings& given)
    : settings(given), arena(given.threads > 0 ? given.threads : tbb::task_arena::automatic) {
  if (settings.backend == Backend::Cpu) return;
  try {
    device = std::make_unique<DeviceSearch>(settings);
    name = device->device();
  } catch (const std::runtime_error& e) {
    message = std::string("contacts are found on the CPU: ") + e.what();
    settings.backend = Backend::Cpu;
  }
}

void ContactBatch::State::runOnDevice() {
  device->run(tasks);
  report = device->report();
}

// The tasks that the device did not answer.
void ContactBatch::State::runOnCpu() {
  const std::size_t left = tasks.size() - report.onDevice;
  if (left == 0) return;
  const auto find = [&](std::size_t k) {
    const SearchTask& task = tasks[k];
    if (!task.answered) task.finder->find(*task.a, *task.b, *task.settings, *task.found);
  };
  // A thread that waits here must not start other work of the caller's.
  arena.execute([&] {
    tbb::this_task_arena::isolate([&] { tbb::parallel_for(std::size_t{0}, tasks.size(), find); });
  });
  workspace->reserve(arena.max_concurrency());
  report.onCpu = left;
}

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

Span<const ContactResult* const> ContactBatch::find(Span<const BatchPair> pairs) {
  State& s = *state_;
  s.report = {};
  while (s.finders.size() < pairs.size()) s.finders.emplace_back(s.workspace);
  while (s.found.size() < pairs.size()) s.results.push_back(&s.found.emplace_back());
  s.rooms.resize(std::max(s.rooms.size(), pairs.size()), SearchTask::kFirstRoom);
  s.tasks.resize(pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k)
    s.tasks[k] = {&pairs[k].a, &pairs[k].b, &pairs[k].settings, &s.finders[k], &s.found[k],
                  &s.rooms[k], true};
  if (s.device) s.runOnDevice();
  s.runOnCpu();
  return {s.results.data(), pairs.size()};
}

std::size_t ContactBatch::deviceBytes() const {
  return state_->device ? state_->device->bytes() : 0;
}

std::map<std::string, DeviceTime> ContactBatch::deviceTimes() {
  return state_->device ? state_->device->deviceTimes() : std::map<std::string, DeviceTime>{};
}

}  // namespace cloudcontact
