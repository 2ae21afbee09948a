// Tasks sorted by cost, the largest first; workers take them by a shared counter.
#include "bullet/look_ahead.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <optional>

namespace cloudcontact {

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

LookAhead::LookAhead(int threads) : threads_(threads), state_(std::make_unique<State>(threads)) {}
LookAhead::~LookAhead() = default;

void LookAhead::begin() {
  step_ = ++steps_;
  tasks_.clear();
  children_.sort();
}

void LookAhead::add(AheadPair& pair, const btCollisionObjectWrapper& a,
                    const btCollisionObjectWrapper& b, const btDispatcherInfo& info) {
  if (const std::size_t cost = pair.prepare(a, b, info)) tasks_.push_back({&pair, cost});
}

void LookAhead::addChildren(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                            const btDispatcherInfo& info) {
  children_.visit(a, b, [&](AheadPair& pair, const auto& first, const auto& second) {
    add(pair, first, second, info);
  });
}

void LookAhead::search() {
  children_.clear();  // Bullet's walk adds those that still exist
  std::sort(tasks_.begin(), tasks_.end(),
            [](const Task& x, const Task& y) { return x.cost > y.cost; });
  searched_ += tasks_.size();
  std::size_t all = 0;
  for (const Task& task : tasks_) all += task.cost;
  std::atomic<std::size_t>& next = state_->next;
  next = 0;
  const auto work = [&](int) {
    for (std::size_t i = next++; i < tasks_.size(); i = next++) {
      // A pair that would keep one thread busy after the others are done.
      const bool large = 2 * tasks_[i].cost * static_cast<std::size_t>(threads_) > all;
      tasks_[i].pair->searchAhead(large ? &state_->shareOut : nullptr);
    }
    state_->done.fetch_add(1, std::memory_order_release);
  };
  const int workers = static_cast<int>(std::min<std::size_t>(threads_, tasks_.size()));
  state_->arena.execute([&] { tbb::parallel_for(0, workers, work, tbb::simple_partitioner()); });
  state_->done.load(std::memory_order_acquire);
  if (!tasks_.empty()) tasks_.front().pair->reserve(threads_);
}

}  // namespace cloudcontact
