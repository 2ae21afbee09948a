// What a query needs while it runs, lent to one finder after the other: as many as run at a time,
// not one each. A thousand finders with memory of their own find it cold whenever they are asked
// again: a M16 contact took 315 us so, 170 with memory that is still warm.
#pragma once

#include "contact/bins.h"
#include "contact/hits.h"

#include <memory>

namespace cloudcontact {

struct FinderWork {
  HitColumns hits;
  HitSearch search;
  Binner binner;

  // Room for what the other has room for.
  void fit(const FinderWork& other);
};

// One work from the process's, given back at the end; the one that the thread had last where that
// is there. Which one it is changes no bit.
class BorrowedWork {
 public:
  BorrowedWork();
  ~BorrowedWork();
  BorrowedWork(const BorrowedWork&) = delete;
  BorrowedWork& operator=(const BorrowedWork&) = delete;
  FinderWork* operator->() { return work_.get(); }

 private:
  std::unique_ptr<FinderWork> work_;
};

// Makes as many works as threads may borrow at a time, each with room for what any has met: so that
// it is not chance which thread still has to ask for memory. For who knows that no query runs.
void levelWorks(int threads);

}  // namespace cloudcontact
