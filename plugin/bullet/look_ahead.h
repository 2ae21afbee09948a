// The cloud pairs of one step, gathered and worked out on several threads before Bullet asks.
#pragma once

#include <cloudcontact/bullet/cloud_dispatcher.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "bullet/compound_children.h"

namespace cloudcontact {

class CloudAlgorithm;

class LookAhead {
 public:
  explicit LookAhead(int threads);
  ~LookAhead();

  int threads() const { return threads_; }
  const CloudDispatcherStatistics& statistics() const { return statistics_; }

  // A step, in this order; Bullet's walk is between the last two. Answers hold no longer.
  void begin();
  void add(CloudAlgorithm& pair, const btCollisionObjectWrapper& a,
           const btCollisionObjectWrapper& b, const btDispatcherInfo& info);
  // What is known of two objects of which one is a compound.
  void addChildren(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                   const btDispatcherInfo& info);
  void work();
  void end() { step_ = 0; }
  // The step's number, from 1; 0 between steps.
  std::uint64_t step() const { return step_; }

  // While Bullet walks: an answer was used; a compound's child was processed; a pair goes.
  void countTaken() { ++statistics_.taken; }
  void remember(CloudAlgorithm& pair, const btCollisionObjectWrapper& a,
                const btCollisionObjectWrapper& b, int& slot) {
    children_.remember(pair, a, b, slot);
  }
  void forget(const CloudAlgorithm& pair, int slot) { children_.forget(pair, slot); }

 private:
  struct Task {
    CloudAlgorithm* pair;
    std::size_t cost;  // [samples], as far as known
  };
  struct Arena;

  int threads_;
  std::unique_ptr<Arena> arena_;
  std::vector<Task> tasks_;
  CompoundChildren children_;
  std::uint64_t step_ = 0, steps_ = 0;
  CloudDispatcherStatistics statistics_;
};

}  // namespace cloudcontact
