// Tasks sorted by cost, the largest first; workers take them by a shared counter. A device takes
// what it can of a large step before.
#include "bullet/look_ahead.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <optional>

namespace cloudcontact {

namespace {
constexpr int kPairsAShare = 16;  // that one thread takes at a time
}  // namespace

struct LookAhead::State {
  explicit State(int threads) : arena(threads) {
    constexpr auto kLimit = tbb::global_control::max_allowed_parallelism;
    const auto limit = static_cast<std::size_t>(threads);
    if (limit > tbb::global_control::active_value(kLimit)) raised.emplace(kLimit, limit);
  }
  std::optional<tbb::global_control> raised;  // if more threads than cores are set
  // Isolated, so that a worker that waits for the shares of its pair takes no other pair meanwhile.
  // The atomics are for ThreadSanitizer, which does not see how TBB hands tasks over.
  const TaskRunner shareOut = [](int count, const std::function<void(int)>& task) {
    std::atomic<int> handed;
    handed.store(0, std::memory_order_release);
    const auto share = [&](int i) {
      handed.load(std::memory_order_acquire);
      task(i);
      handed.fetch_add(1, std::memory_order_release);
    };
    tbb::this_task_arena::isolate(
        [&] { tbb::parallel_for(0, count, share, tbb::simple_partitioner()); });
    handed.load(std::memory_order_acquire);
  };
  tbb::task_arena arena;
  std::atomic<std::size_t> next{0};
  std::atomic<int> done{0};  // workers; for ThreadSanitizer, as above
};

LookAhead::LookAhead(int threads, std::unique_ptr<DeviceSearch> device, std::size_t leastForDevice)
    : threads_(threads),
      device_(std::move(device)),
      leastForDevice_(leastForDevice),
      state_(std::make_unique<State>(threads)) {}
LookAhead::~LookAhead() = default;

void LookAhead::begin() {
  step_ = ++steps_;
  tasks_.clear();
  known_.clear();
  children_.sort();
}

void LookAhead::addChildren(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                            const btDispatcherInfo& info) {
  children_.visit(a, b, [&](AheadPair& pair, const auto& first, const auto& second) {
    if (const std::size_t cost = pair.prepare(first, second, info)) tasks_.push_back({&pair, cost});
  });
}

void LookAhead::share(int count, const std::function<void(int)>& each) {
  state_->done.store(0, std::memory_order_release);
  const auto some = [&](const tbb::blocked_range<int>& range) {
    state_->done.load(std::memory_order_acquire);
    for (int i = range.begin(); i < range.end(); ++i) each(i);
    state_->done.fetch_add(1, std::memory_order_release);
  };
  const tbb::blocked_range<int> all(0, count, kPairsAShare);
  state_->arena.execute([&] { tbb::parallel_for(all, some); });
  state_->done.load(std::memory_order_acquire);
}

// Reads the queries of all pairs, and moves the contacts of those that need no search.
void LookAhead::prepare(const btDispatcherInfo& info, bool finishes) {
  const auto one = [&](int i) {
    Known& known = known_[i];
    const btCollisionObjectWrapper a = wrapped(*known.a), b = wrapped(*known.b);
    known.cost = known.pair->prepare(a, b, info);
    if (finishes && known.cost == 0) known.done = known.pair->finish(a, b, info);
  };
  share(static_cast<int>(known_.size()), std::ref(one));  // a copy would be allocated
  for (const Known& known : known_)
    if (known.cost > 0) tasks_.push_back({known.pair, known.cost});
}

void LookAhead::finish(const btDispatcherInfo& info) {
  share(static_cast<int>(known_.size()), [&](int i) {
    Known& known = known_[i];
    if (known.cost > 0) known.done = known.pair->finish(wrapped(*known.a), wrapped(*known.b), info);
  });
}

const std::vector<int>& LookAhead::left(int count) {
  left_.clear();
  int place = 0;
  for (const Known& known : known_) {
    while (place < known.place) left_.push_back(place++);
    if (!known.done) left_.push_back(place);
    ++place;
  }
  while (place < count) left_.push_back(place++);
  return left_;
}

void LookAhead::search(const btDispatcherInfo& info, bool finishes) {
  prepare(info, finishes);
  children_.clear();  // Bullet's walk adds those that still exist
  const std::size_t searched = tasks_.size();
  searched_ += searched;
  if (device_ && tasks_.size() >= leastForDevice_) searchOnDevice();
  searchOnThreads(tasks_);
  if (!finishes) return;
  if (searched > 0) finish(info);
  for (const Known& known : known_) written_ += known.done;
}

// Threads search what has no kernels while the device works. What it does not answer stays in
// tasks_. A device that fails once is not asked again.
void LookAhead::searchOnDevice() {
  const auto start = std::chrono::steady_clock::now();
  onDevice_.clear();
  searches_.clear();
  std::size_t apart = 0;
  std::erase_if(tasks_, [&](const Task& task) {
    const SearchTask search = task.pair->deviceTask();
    apart += search.apart;
    if (!DeviceSearch::takes(search)) return false;
    onDevice_.push_back(task);
    searches_.push_back(search);
    return true;
  });
  const std::size_t others = tasks_.size();
  if (searches_.size() < leastForDevice_) {
    tasks_.insert(tasks_.end(), onDevice_.begin(), onDevice_.end());
    return;
  }
  try {
    device_->run(searches_, [&] { searchOnThreads(tasks_); });
    tasks_.clear();
    BatchReport report = device_->report();
    report.nearMisses += apart;
    report.shapes += others - apart;
    report.onCpu = others + searches_.size() - report.onDevice;
    deviceReport_ += report;
    ++deviceSteps_;
  } catch (const std::exception& failure) {
    deviceFailure_ = failure.what();
    device_.reset();
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  for (std::size_t k = 0; k < searches_.size(); ++k) {
    if (searches_[k].answered)
      onDevice_[k].pair->searchedOnDevice(took.count() / double(searches_.size()));
    else
      tasks_.push_back(onDevice_[k]);
  }
}

void LookAhead::searchOnThreads(std::vector<Task>& tasks) {
  if (tasks.empty()) return;
  std::sort(tasks.begin(), tasks.end(),
            [](const Task& x, const Task& y) { return x.cost > y.cost; });
  std::size_t all = 0;
  for (const Task& task : tasks) all += task.cost;
  std::atomic<std::size_t>& next = state_->next;
  next = 0;
  const auto work = [&](int) {
    for (std::size_t i = next++; i < tasks.size(); i = next++) {
      // A pair that would keep one thread busy after the others are done.
      const bool large = 2 * tasks[i].cost * static_cast<std::size_t>(threads_) > all;
      tasks[i].pair->searchAhead(large ? &state_->shareOut : nullptr);
    }
    state_->done.fetch_add(1, std::memory_order_release);
  };
  const int workers = static_cast<int>(std::min<std::size_t>(threads_, tasks.size()));
  state_->arena.execute([&] { tbb::parallel_for(0, workers, work, tbb::simple_partitioner()); });
  state_->done.load(std::memory_order_acquire);
  tasks.front().pair->reserve(threads_);
}

}  // namespace cloudcontact
