// Adds up the reports of pairs.
#include "bullet/narrow_phase.h"

#include <algorithm>
#include <iostream>
#include <map>
#include <utility>

#include "bullet/matter_check.h"

namespace cloudcontact {

namespace {

// Children of a compound have several reports for the same objects.
class Reports {
 public:
  void add(const PairReport& report) {
    if (report.answers() == 0) return;
    const auto [place, isNew] = places_.try_emplace({report.a, report.b}, all_.size());
    if (isNew) {
      all_.push_back(report);
      return;
    }
    PairReport& sum = all_[place->second];
    sum.last = report.last;
    sum.searched += report.searched;
    sum.shapes += report.shapes;
    sum.moved += report.moved;
    sum.device += report.device;
    sum.work += report.work;
    sum.bytes += report.bytes;
    sum.samples += report.samples;
    sum.seconds += report.seconds;
    sum.expectedError = std::max(sum.expectedError, report.expectedError);
    sum.error = std::max(sum.error, report.error);
    sum.depth = std::max(sum.depth, report.depth);
    sum.level = std::min(sum.level, report.level);
    for (int side = 0; side < 2; ++side) {
      sum.voxelLevel[side] = std::max(sum.voxelLevel[side], report.voxelLevel[side]);
      sum.voxel[side] = std::max(sum.voxel[side], report.voxel[side]);
    }
    sum.tolerance = std::max(sum.tolerance, report.tolerance);
    sum.coarser += report.coarser;
    sum.refined += report.refined;
    sum.eased += report.eased;
  }
  std::vector<PairReport> take() { return std::move(all_); }

 private:
  std::map<std::pair<const btCollisionObject*, const btCollisionObject*>, std::size_t> places_;
  std::vector<PairReport> all_;
};

}  // namespace

void NarrowPhase::countFailure(const char* message) {
  {
    const std::lock_guard lock(mutex_);
    statistics_.failures += 1;
    statistics_.lastFailure = message;
  }
  tell(message);
}

CloudContactStatistics NarrowPhase::statistics() const {
  CloudContactStatistics all;
  {
    const std::lock_guard lock(mutex_);
    all = statistics_;
    all.work = workspace_->work();
    all.work -= workBefore_;
    for (const PairReport* report : reports_) all.bytes += report->bytes;
  }
  all.countedSeconds = budget_.lastStep();
  for (Share& share : shares_) {
    const std::lock_guard lock(share.mutex);
    all.pairs += share.sum.pairs;
    all.samples += share.sum.samples;
    all.contacts += share.sum.contacts;
    all.seconds += share.sum.seconds;
    all.reused += share.sum.reused;
    all.shapes += share.sum.shapes;
    all.device += share.sum.device;
    all.coarser += share.sum.coarser;
    all.refined += share.sum.refined;
    all.eased += share.sum.eased;
  }
  return all;
}

void NarrowPhase::resetStatistics() {
  for (Share& share : shares_) {
    const std::lock_guard lock(share.mutex);
    share.sum = {};
  }
  const std::lock_guard lock(mutex_);
  statistics_ = {};
  workBefore_ = workspace_->work();
}

void NarrowPhase::checkMatter(const btCollisionObject& object) {
  {
    const std::lock_guard lock(mutex_);
    if (!weighed_.insert(&object).second) return;
  }
  std::vector<const char*> faults;
  {
    const std::lock_guard lock(weighing_);
    faults = wrongMatter(object, masses_);
  }
  for (const char* const fault : faults) tell(fault);
}

void NarrowPhase::tell(const char* message) {
  {
    const std::lock_guard lock(mutex_);
    if (std::find(told_.begin(), told_.end(), message) != told_.end()) return;
    told_.emplace_back(message);
  }
  const std::lock_guard lock(telling_);
  if (settings_.onFailure)
    settings_.onFailure(message);
  else
    std::cerr << "cloudcontact: " << message << '\n';
}

void NarrowPhase::remove(const PairReport& pair) {
  const std::lock_guard lock(mutex_);
  std::erase(reports_, &pair);
  if (settings_.keepReports) parted_.push_back(pair);
  if (parted_.size() < 2 * kept_ + 64) return;
  Reports sum;  // so that a pair that meets often takes no more room
  for (const PairReport& report : parted_) sum.add(report);
  parted_ = sum.take();
  kept_ = parted_.size();
}

std::vector<PairReport> NarrowPhase::pairs() const {
  const std::lock_guard lock(mutex_);
  Reports sum;
  for (const PairReport& report : parted_) sum.add(report);
  for (const PairReport* report : reports_) sum.add(*report);
  return sum.take();
}

}  // namespace cloudcontact
