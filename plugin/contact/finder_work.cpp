// Works that are lent, behind one lock: it is held for a tenth of a microsecond a query.
#include "contact/finder_work.h"

#include <algorithm>
#include <mutex>
#include <utility>

namespace cloudcontact {

namespace {

struct Works {
  std::mutex mutex;
  std::vector<std::unique_ptr<FinderWork>> spare;
  std::size_t made = 0;

  // Room is kept for all to come back: giving one back cannot fail.
  std::unique_ptr<FinderWork> make() {
    spare.reserve(made + 1);
    auto work = std::make_unique<FinderWork>();
    ++made;
    return work;
  }
};

// Never destroyed: finders may outlive everything else.
Works& works() {
  static Works& all = *new Works;
  return all;
}

thread_local const FinderWork* last = nullptr;  // only compared

}  // namespace

void FinderWork::fit(const FinderWork& other) {
  hits.fit(other.hits);
  search.fit(other.search);
  binner.fit(other.binner);
}

BorrowedWork::BorrowedWork() {
  Works& all = works();
  const std::lock_guard lock(all.mutex);
  if (all.spare.empty()) {
    work_ = all.make();
  } else {
    auto found = std::find_if(all.spare.begin(), all.spare.end(),
                              [](const auto& work) { return work.get() == last; });
    if (found == all.spare.end()) --found;
    work_ = std::move(*found);
    all.spare.erase(found);
  }
  last = work_.get();
}

BorrowedWork::~BorrowedWork() {
  Works& all = works();
  const std::lock_guard lock(all.mutex);
  all.spare.push_back(std::move(work_));
}

void levelWorks(int threads) {
  Works& all = works();
  const std::lock_guard lock(all.mutex);
  while (static_cast<int>(all.spare.size()) < threads) all.spare.push_back(all.make());
  FinderWork& largest = *all.spare.front();
  for (const auto& work : all.spare)
    if (work.get() != &largest) largest.fit(*work);
  for (const auto& work : all.spare)
    if (work.get() != &largest) work->fit(largest);
}

}  // namespace cloudcontact
