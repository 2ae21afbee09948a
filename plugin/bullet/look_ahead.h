// LookAhead: gathers the cloud pairs of a step and searches them on a device or on several threads
// before Bullet's walk reaches them.
#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <cloudcontact/base/task_runner.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bullet/compound_children.h"
#include "device/device_search.h"

struct btDispatcherInfo;

namespace cloudcontact {

// A whole object, as Bullet's walk has it.
inline btCollisionObjectWrapper wrapped(const btCollisionObject& object) {
  return {nullptr, object.getCollisionShape(), &object, object.getWorldTransform(), -1, -1};
}

// A pair that can be searched ahead of processCollision().
class AheadPair {
 public:
  // Reads the query that processCollision() will make in this step if nothing changes until then.
  // Returns its approximate cost in samples, or 0 if there is nothing to search. Different pairs
  // may be prepared at the same time.
  virtual std::size_t prepare(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                              const btDispatcherInfo& info) noexcept = 0;
  // Searches that query; processCollision() takes the result if its own query is equal. Different
  // pairs may be searched at the same time. A large search is split up with `shareOut`.
  virtual void searchAhead(const TaskRunner* shareOut) noexcept = 0;
  // The same search for a device, and afterwards, if the device answered it, the time it took [s].
  virtual SearchTask deviceTask() noexcept = 0;
  virtual void searchedOnDevice(double seconds) noexcept = 0;
  // After the searches of all pairs: builds and writes the contact as processCollision() will,
  // which then only takes it. Only where no callback asks to be called in the walk's order.
  // Different pairs may be finished at the same time. Whether nothing is left for the walk.
  virtual bool finish(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                      const btDispatcherInfo& info) noexcept = 0;
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
  // `device` may be null; it gets batches of `leastForDevice` pairs and more.
  LookAhead(int threads, std::unique_ptr<DeviceSearch> device, std::size_t leastForDevice);
  ~LookAhead();

  int threads() const { return threads_; }
  std::size_t searched() const { return searched_; }  // pairs, in all steps
  std::size_t taken() const { return taken_; }        // results that Bullet's walk used
  std::size_t written() const { return written_; }    // contacts that were in their manifolds
  DeviceSearch* device() { return device_.get(); }    // null: none, or it failed
  std::size_t deviceSteps() const { return deviceSteps_; }
  const BatchReport& deviceReport() const { return deviceReport_; }  // summed over these steps
  const std::string& deviceFailure() const { return deviceFailure_; }

  // One step, in this order; Bullet's walk is before end(), which
  // ends the results' validity.
  void begin();
  // `place`: of the pair in Bullet's array.
  void add(AheadPair& pair, const btCollisionObject& a, const btCollisionObject& b, int place) {
    known_.push_back({&pair, &a, &b, place});
  }
  // Adds the known pairs of children of two objects, one of which is a compound.
  void addChildren(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                   const btDispatcherInfo& info);
  // `finishes`: writes contacts, too, since no callback minds. A pair that needs no search is
  // finished while its memory is at hand.
  void search(const btDispatcherInfo& info, bool finishes);
  // After that: the places of the pairs that are not finished, and of those not added, out of
  // `count`, in order.
  const std::vector<int>& left(int count);
  void end() { step_ = 0; }
  // The step's number, from 1; 0 between steps.
  std::uint64_t step() const { return step_; }

  // Calls `each` with 0 to count - 1, in any order, on all threads.
  void share(int count, const std::function<void(int)>& each);

  // During Bullet's walk: a result was used, a compound's child was processed, a pair is deleted.
  void countTaken() { taken_.fetch_add(1, std::memory_order_relaxed); }
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
  // A pair of whole objects.
  struct Known {
    AheadPair* pair;
    const btCollisionObject *a, *b;
    int place = 0;
    bool done = false;
    std::size_t cost = 0;
  };
  struct State;
  void prepare(const btDispatcherInfo& info, bool finishes);
  void finish(const btDispatcherInfo& info);
  void searchOnDevice();
  void searchOnThreads(std::vector<Task>& tasks);

  int threads_;
  std::unique_ptr<DeviceSearch> device_;
  std::size_t leastForDevice_;
  std::unique_ptr<State> state_;
  std::vector<Known> known_;  // in the order of their places
  std::vector<int> left_;
  std::vector<Task> tasks_;           // without those that the device answered
  std::vector<Task> onDevice_;        // that the device may answer
  std::vector<SearchTask> searches_;  // of onDevice_
  CompoundChildren children_;
  std::uint64_t step_ = 0, steps_ = 0;
  std::size_t searched_ = 0, written_ = 0, deviceSteps_ = 0;
  std::atomic<std::size_t> taken_{0};
  BatchReport deviceReport_;
  std::string deviceFailure_;
};

}  // namespace cloudcontact
