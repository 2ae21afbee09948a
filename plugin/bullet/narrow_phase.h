// What all cloud pairs of a world share: settings, counters, and a lock for dispatchers that run
// pairs in parallel (Bullet's btCollisionDispatcherMt).
#pragma once

#include <cloudcontact/bullet/cloud_contact.h>

#include <mutex>
#include <shared_mutex>
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

  // A pair with a soft body pushes both of its bodies as it is processed, while other pairs read
  // how they move.
  std::shared_lock<std::shared_mutex> whileReading() { return std::shared_lock(moving_); }
  std::unique_lock<std::shared_mutex> whilePushing() { return std::unique_lock(moving_); }

  // The pairs with a soft body that live, in the order in which they came.
  void add(const SoftAlgorithm& pair);
  void remove(const SoftAlgorithm& pair);
  const std::vector<const SoftAlgorithm*>& softPairs() const { return softPairs_; }

 private:
  CloudContactSettings settings_;
  mutable std::mutex mutex_;  // of all below
  std::shared_mutex moving_;  // how bodies move
  CloudContactStatistics statistics_;
  std::vector<const SoftAlgorithm*> softPairs_;
};

}  // namespace cloudcontact
