// Tasks by cost, the dearest first, handed out by a counter.
#include "bullet/look_ahead.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <optional>

#include "bullet/cloud_algorithm.h"

namespace cloudcontact {

struct LookAhead::Arena {
  explicit Arena(int threads) : arena(threads) {
    constexpr auto kLimit = tbb::global_control::max_allowed_parallelism;
    const auto wanted = static_cast<std::size_t>(threads);
    if (wanted > tbb::global_control::active_value(kLimit)) more.emplace(kLimit, wanted);
  }
  std::optional<tbb::global_control> more;  // threads than cores, where that is asked for
  // Whoever waits for the shares of a pair takes no other pair on meanwhile. ThreadSanitizer does
  // not see how TBB hands them over: that is what the atomics are for.
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
  std::atomic<int> done{0};  // workers; ThreadSanitizer does not see TBB's own waiting
};

LookAhead::LookAhead(int threads) : threads_(threads), arena_(std::make_unique<Arena>(threads)) {}
LookAhead::~LookAhead() = default;

void LookAhead::begin() {
  step_ = ++steps_;
  tasks_.clear();
  children_.sort();
}

void LookAhead::add(CloudAlgorithm& pair, const btCollisionObjectWrapper& a,
                    const btCollisionObjectWrapper& b, const btDispatcherInfo& info) {
  if (const std::size_t cost = pair.prepare(a, b, info)) tasks_.push_back({&pair, cost});
}

void LookAhead::addChildren(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                            const btDispatcherInfo& info) {
  children_.visit(a, b, [&](CloudAlgorithm& pair, const auto& first, const auto& second) {
    add(pair, first, second, info);
  });
}

void LookAhead::work() {
  children_.clear();  // Bullet's walk tells which live on
  std::sort(tasks_.begin(), tasks_.end(),
            [](const Task& x, const Task& y) { return x.cost > y.cost; });
  statistics_.ahead += tasks_.size();
  std::size_t all = 0;
  for (const Task& task : tasks_) all += task.cost;
  std::atomic<std::size_t>& next = arena_->next;
  next = 0;
  const auto takeOn = [&](int) {
    for (std::size_t i = next++; i < tasks_.size(); i = next++) {
      // What would keep one thread busy after the others are done.
      const bool large = 2 * tasks_[i].cost * static_cast<std::size_t>(threads_) > all;
      tasks_[i].pair->workOut(large ? &arena_->shareOut : nullptr);
    }
    arena_->done.fetch_add(1, std::memory_order_release);
  };
  const int workers = static_cast<int>(std::min<std::size_t>(threads_, tasks_.size()));
  arena_->arena.execute([&] { tbb::parallel_for(0, workers, takeOn, tbb::simple_partitioner()); });
  arena_->done.load(std::memory_order_acquire);
  ContactFinder::makeRoom(threads_);
}

}  // namespace cloudcontact
