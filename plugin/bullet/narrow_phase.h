// What all cloud pairs of a world share: settings and counters.
#pragma once

#include <cloudcontact/bullet/registration.h>

#include <mutex>
#include <vector>

namespace cloudcontact {

class SoftAlgorithm;

class NarrowPhase {
 public:
  explicit NarrowPhase(const CloudContactSettings& settings) : settings_(settings) {}

  const CloudContactSettings& settings() const { return settings_; }

  void count(double seconds, std::size_t samples, std::size_t contacts);
  void countFailure(const char* what);
  CloudContactStatistics statistics() const;
  void resetStatistics();

  // The pairs with a soft body that live, in the order in which they came.
  void add(const SoftAlgorithm& pair);
  void remove(const SoftAlgorithm& pair);
  const std::vector<const SoftAlgorithm*>& softPairs() const { return softPairs_; }

 private:
  CloudContactSettings settings_;
  mutable std::mutex mutex_;  // a user's dispatcher may run pairs in parallel
  CloudContactStatistics statistics_;
  std::vector<const SoftAlgorithm*> softPairs_;
};

}  // namespace cloudcontact
