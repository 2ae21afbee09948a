// Counters and finders behind one lock, taken a few times a pair and step.
#include "narrow_phase.h"

namespace cloudcontact {

std::unique_ptr<ContactFinder> NarrowPhase::borrow() {
  const std::lock_guard lock(mutex_);
  if (idle_.empty()) return std::make_unique<ContactFinder>();
  auto finder = std::move(idle_.back());
  idle_.pop_back();
  return finder;
}

void NarrowPhase::giveBack(std::unique_ptr<ContactFinder> finder) {
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(finder));
}

void NarrowPhase::count(double seconds, std::size_t samples, std::size_t contacts) {
  const std::lock_guard lock(mutex_);
  statistics_.seconds += seconds;
  statistics_.pairs += 1;
  statistics_.samples += samples;
  statistics_.contacts += contacts;
}

void NarrowPhase::countFailure(const char* what) {
  const std::lock_guard lock(mutex_);
  statistics_.failures += 1;
  statistics_.lastFailure = what;
}

CloudContactStatistics NarrowPhase::statistics() const {
  const std::lock_guard lock(mutex_);
  return statistics_;
}

void NarrowPhase::resetStatistics() {
  const std::lock_guard lock(mutex_);
  statistics_ = {};
}

}  // namespace cloudcontact
