// What all cloud pairs of a world share: settings, counters, and idle finders.
#pragma once

#include <cloudcontact/bullet/registration.h>

#include <mutex>

namespace cloudcontact {

class NarrowPhase {
 public:
  explicit NarrowPhase(const CloudContactSettings& settings) : settings_(settings) {}

  const CloudContactSettings& settings() const { return settings_; }

  // A finder for one query; finders are many times larger than a pair, so pairs borrow them.
  std::unique_ptr<ContactFinder> borrow();
  void giveBack(std::unique_ptr<ContactFinder> finder);

  void count(double seconds, std::size_t samples, std::size_t contacts);
  void countFailure(const char* what);
  CloudContactStatistics statistics() const;
  void resetStatistics();

 private:
  CloudContactSettings settings_;
  mutable std::mutex mutex_;  // a user's dispatcher may run pairs in parallel
  CloudContactStatistics statistics_;
  std::vector<std::unique_ptr<ContactFinder>> idle_;
};

}  // namespace cloudcontact
