// The memory that queries work in. Finders share it: there is one set for each query that runs at
// the same time, not one for each finder. With a set of its own, each of a thousand finders would
// find it cold in the cache: an M16 contact then takes 315 us instead of 170.
#pragma once

#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "contact/binner.h"
#include "contact/hit_search.h"
#include "contact/patch_hits.h"
#include "contact/touched_matter.h"

namespace cloudcontact {

struct QueryMemory {
  HitColumns hits;
  HitSearch search;
  Binner binner;
  TouchedMatter matter;
  PatchHits wet;
  KnownMeets known;
  HitColumns pressless;  // hits that come to no contact
  ContactResult trial;   // that may not be used

  // Reserves what `other` has reserved.
  void reserveLike(const QueryMemory& other);
  // What was done in it since the last call.
  WorkCounts takeWork();
};

// A pool of sets of memory. Any thread may borrow a set and give it back.
class QueryMemoryPool {
 public:
  // The set that this thread used last if it is free, else another. Results do not depend on it.
  std::unique_ptr<QueryMemory> borrow();
  // `work`: what was done in it.
  void giveBack(std::unique_ptr<QueryMemory> memory, const WorkCounts& work) noexcept;
  WorkCounts work() const;  // in all sets that are back
  // Makes at least `sets` sets, each with what any of them has reserved, so that later queries of
  // the same size allocate nothing in any thread. Borrowed sets do not count.
  void reserve(int sets);

 private:
  struct Set {
    std::unique_ptr<QueryMemory> memory;
    std::thread::id lastUser;
  };
  std::unique_ptr<QueryMemory> make();

  mutable std::mutex mutex_;
  std::vector<Set> free_;
  std::size_t made_ = 0;
  WorkCounts work_;
};

// Borrows a set until its own end, and then adds what was done in it to `sum`.
class BorrowedMemory {
 public:
  BorrowedMemory(QueryMemoryPool& pool, WorkCounts& sum)
      : pool_(pool), sum_(sum), memory_(pool.borrow()) {}
  ~BorrowedMemory() {
    const WorkCounts work = memory_->takeWork();
    sum_ += work;
    pool_.giveBack(std::move(memory_), work);
  }
  BorrowedMemory(const BorrowedMemory&) = delete;
  BorrowedMemory& operator=(const BorrowedMemory&) = delete;
  QueryMemory* operator->() { return memory_.get(); }
  QueryMemory& operator*() { return *memory_; }

 private:
  QueryMemoryPool& pool_;
  WorkCounts& sum_;
  std::unique_ptr<QueryMemory> memory_;
};

}  // namespace cloudcontact
