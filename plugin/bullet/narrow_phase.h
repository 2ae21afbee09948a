// What all cloud pairs of a world share: settings and counters.
#pragma once

#include <cloudcontact/bullet/registration.h>

#include <mutex>

namespace cloudcontact {

class NarrowPhase {
 public:
  explicit NarrowPhase(const CloudContactSettings& settings) : settings_(settings) {}

  const CloudContactSettings& settings() const { return settings_; }

  void count(double seconds, std::size_t samples, std::size_t contacts);
  void countFailure(const char* what);
  CloudContactStatistics statistics() const;
  void resetStatistics();

 private:
  CloudContactSettings settings_;
  mutable std::mutex mutex_;  // a user's dispatcher may run pairs in parallel
  CloudContactStatistics statistics_;
};

}  // namespace cloudcontact
