// A pool behind one lock, held for a tenth of a microsecond a query.
#include "contact/query_memory.h"

#include <algorithm>
#include <utility>

namespace cloudcontact {

void QueryMemory::reserveLike(const QueryMemory& other) {
  hits.reserveLike(other.hits);
  pressless.reserveLike(other.pressless);
  search.reserveLike(other.search);
  binner.reserveLike(other.binner);
  wet.reserveLike(other.wet);
  trial.patches.reserve(other.trial.patches.capacity());
  trial.points.reserve(other.trial.points.capacity());
  for (int side = 0; side < 2; ++side)
    known.of[side].meets.reserve(other.known.of[side].meets.capacity());
}

WorkCounts QueryMemory::takeWork() {
  WorkCounts work = search.takeWork();
  work += wet.takeWork();
  work += matter.takeWork();
  return work;
}

WorkCounts QueryMemoryPool::work() const {
  const std::lock_guard lock(mutex_);
  return work_;
}

// Keeps room for all sets to come back, so that giveBack() cannot fail.
std::unique_ptr<QueryMemory> QueryMemoryPool::make() {
  free_.reserve(made_ + 1);
  auto memory = std::make_unique<QueryMemory>();
  ++made_;
  return memory;
}

std::unique_ptr<QueryMemory> QueryMemoryPool::borrow() {
  const std::lock_guard lock(mutex_);
  if (free_.empty()) return make();
  const auto own = [](const Set& set) { return set.lastUser == std::this_thread::get_id(); };
  auto found = std::find_if(free_.rbegin(), free_.rend(), own);
  const auto chosen = found == free_.rend() ? free_.end() - 1 : found.base() - 1;
  std::unique_ptr<QueryMemory> memory = std::move(chosen->memory);
  free_.erase(chosen);
  return memory;
}

void QueryMemoryPool::giveBack(std::unique_ptr<QueryMemory> memory,
                               const WorkCounts& work) noexcept {
  const std::lock_guard lock(mutex_);
  work_ += work;
  free_.push_back({std::move(memory), std::this_thread::get_id()});
}

void QueryMemoryPool::reserve(int sets) {
  const std::lock_guard lock(mutex_);
  while (static_cast<int>(free_.size()) < sets) free_.push_back({make(), {}});
  if (free_.empty()) return;
  QueryMemory& largest = *free_.front().memory;
  for (const Set& set : free_)
    if (set.memory.get() != &largest) largest.reserveLike(*set.memory);
  for (const Set& set : free_)
    if (set.memory.get() != &largest) set.memory->reserveLike(largest);
}

}  // namespace cloudcontact
