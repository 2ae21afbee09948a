// NarrowPhase: what the cloud pairs of one CloudContact share. Bullet may run pairs in parallel
// (btCollisionDispatcherMt), hence the locks.
#pragma once

#include <cloudcontact/bullet/cloud_contact_settings.h>
#include <cloudcontact/bullet/pair_report.h>
#include <cloudcontact/contact/contact_finder.h>

#include <array>
#include <functional>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <string>
#include <thread>
#include <unordered_set>
#include <vector>

#include "bullet/matter_check.h"
#include "bullet/work_budget.h"

namespace cloudcontact {

class CloudAlgorithm;
class SoftAlgorithm;

// What a pair was searched with (LevelChoice).
struct LevelCount {
  bool coarser = false, eased = false;
  std::size_t refined = 0;
};

class NarrowPhase {
 public:
  explicit NarrowPhase(const CloudContactSettings& settings)
      : settings_(settings), budget_(settings.fidelity.budget) {}

  const CloudContactSettings& settings() const { return settings_; }
  // The memory that the finders of all pairs work in.
  const std::shared_ptr<ContactWorkspace>& workspace() const { return workspace_; }

  // One pair that was processed.
  void count(double seconds, std::size_t samples, std::size_t contacts,
             Answer how = Answer::Searched, const LevelCount& levels = {}) {
    Share& own = shares_[std::hash<std::thread::id>{}(std::this_thread::get_id()) % kShares];
    const std::lock_guard lock(own.mutex);
    CloudContactStatistics& sum = own.sum;
    sum.coarser += levels.coarser;
    sum.refined += levels.refined;
    sum.eased += levels.eased;
    sum.reused += how == Answer::Moved;
    sum.device += how == Answer::Device;
    sum.seconds += seconds;
    sum.pairs += 1;
    sum.samples += samples;
    sum.contacts += contacts;
    sum.shapes += how == Answer::Shapes;
  }
  // Tells of each message once (CloudContactSettings::onFailure).
  void countFailure(const char* message);
  // Tells what is wrong with a body when it first meets another (wrongMatter()).
  void checkMatter(const btCollisionObject& object);
  CloudContactStatistics statistics() const;
  void resetStatistics();

  WorkBudget& budget() { return budget_; }

  // A pair's report stays its own while the pair lives. Removed ones are kept if the settings ask.
  void add(const PairReport& pair) {
    const std::lock_guard lock(mutex_);
    reports_.push_back(&pair);
  }
  void remove(const PairReport& pair);
  std::vector<PairReport> pairs() const;

  // The pairs, in order of creation.
  void add(CloudAlgorithm& pair) {
    const std::lock_guard lock(mutex_);
    algorithms_.push_back(&pair);
  }
  void remove(CloudAlgorithm& pair) {
    const std::lock_guard lock(mutex_);
    std::erase(algorithms_, &pair);
  }
  const std::vector<CloudAlgorithm*>& algorithms() const { return algorithms_; }

  // A pair with a soft body changes the velocities of both bodies while it is processed. Other
  // pairs read velocities under the shared lock.
  std::shared_lock<std::shared_mutex> lockToRead() { return std::shared_lock(motion_); }
  std::unique_lock<std::shared_mutex> lockToPush() { return std::unique_lock(motion_); }

  // Held while the triangles of Bullet's shapes are read.
  std::mutex& reading() { return reading_; }

  // The pairs with a soft body, in order of creation.
  void add(const SoftAlgorithm& pair) {
    const std::lock_guard lock(mutex_);
    softPairs_.push_back(&pair);
  }
  void remove(const SoftAlgorithm& pair) {
    const std::lock_guard lock(mutex_);
    std::erase(softPairs_, &pair);
  }
  const std::vector<const SoftAlgorithm*>& softPairs() const { return softPairs_; }

 private:
  CloudContactSettings settings_;
  WorkBudget budget_;
  std::shared_ptr<ContactWorkspace> workspace_ = std::make_shared<ContactWorkspace>();
  // Threads that write contacts at the same time do not wait for each other's counts.
  struct alignas(64) Share {
    std::mutex mutex;
    CloudContactStatistics sum;
  };
  static constexpr std::size_t kShares = 32;
  mutable std::array<Share, kShares> shares_;
  mutable std::mutex mutex_;  // all but settings_, workspace_, shares_, motion_, telling_, masses_
  std::shared_mutex motion_;  // velocities of bodies
  std::mutex reading_;
  CloudContactStatistics statistics_;  // of failures
  WorkCounts workBefore_;              // the last reset
  std::vector<const PairReport*> reports_;
  std::vector<CloudAlgorithm*> algorithms_;
  std::vector<PairReport> parted_;
  std::size_t kept_ = 0;  // of parted_, when it was last added up
  std::vector<const SoftAlgorithm*> softPairs_;
  void tell(const char* message);

  std::vector<std::string> told_;
  std::unordered_set<const btCollisionObject*> weighed_;
  std::mutex telling_;
  CloudMasses masses_;
  std::mutex weighing_;  // masses_
};

}  // namespace cloudcontact
