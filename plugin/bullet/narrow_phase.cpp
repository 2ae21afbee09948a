// Counters behind one lock, taken once a pair and step.
#include "bullet/narrow_phase.h"

namespace cloudcontact {

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

void NarrowPhase::add(const SoftAlgorithm& pair) {
  const std::lock_guard lock(mutex_);
  softPairs_.push_back(&pair);
}

void NarrowPhase::remove(const SoftAlgorithm& pair) {
  const std::lock_guard lock(mutex_);
  std::erase(softPairs_, &pair);
}

}  // namespace cloudcontact
