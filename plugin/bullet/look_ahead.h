// LookAhead: gathers the cloud pairs of a step and searches them on several threads before Bullet's
// walk reaches them.
#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>
#include <cloudcontact/base/task_runner.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "bullet/compound_children.h"

struct btDispatcherInfo;

namespace cloudcontact {

// A pair that can be searched ahead of processCollision().
class AheadPair {
 public:
  // Reads the query that processCollision() will make in this step if nothing changes until then.
  // Returns its approximate cost in samples, or 0 if there is nothing to search.
  virtual std::size_t prepare(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                              const btDispatcherInfo& info) noexcept = 0;
  // Searches that query; processCollision() takes the result if its own query is equal. Different
  // pairs may be searched at the same time. A large search is split up with `shareOut`.
  virtual void searchAhead(const TaskRunner* shareOut) noexcept = 0;
  // Reserves memory for searches on `threads` threads, in the workspace of this pair and others.
  // Call it between searches.
  virtual void reserve(int threads) = 0;

 protected:
  ~AheadPair() = default;
};

// Makes algorithms that are an AheadPair.
class AheadPairFactory : public btCollisionAlgorithmCreateFunc {};

class LookAhead {
 public:
  explicit LookAhead(int threads);
  ~LookAhead();

  int threads() const { return threads_; }
  std::size_t searched() const { return searched_; }  // pairs, in all steps
  std::size_t taken() const { return taken_; }        // results that Bullet's walk used

  // One step, in this order; Bullet's walk is between search() and end(), which ends the results'
  // validity.
  void begin();
  void add(AheadPair& pair, const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
           const btDispatcherInfo& info);
  // Adds the known pairs of children of two objects, one of which is a compound.
  void addChildren(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                   const btDispatcherInfo& info);
  void search();
  void end() { step_ = 0; }
  // The step's number, from 1; 0 between steps.
  std::uint64_t step() const { return step_; }

  // During Bullet's walk: a result was used, a compound's child was processed, a pair is deleted.
  void countTaken() { ++taken_; }
  void remember(AheadPair& pair, const btCollisionObjectWrapper& a,
                const btCollisionObjectWrapper& b, int& slot) {
    children_.remember(pair, a, b, slot);
  }
  void forget(const AheadPair& pair, int slot) { children_.forget(pair, slot); }

 private:
  struct Task {
    AheadPair* pair;
    std::size_t cost;  // [samples] estimate
  };
  struct State;

  int threads_;
  std::unique_ptr<State> state_;
  std::vector<Task> tasks_;
  CompoundChildren children_;
  std::uint64_t step_ = 0, steps_ = 0;
  std::size_t searched_ = 0, taken_ = 0;
};

}  // namespace cloudcontact
