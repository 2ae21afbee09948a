// CloudDispatcher: Bullet's own dispatcher, which computes a step's cloud pairs on all cores. One
// line of a program changes:
//
//   cloudcontact::CloudDispatcher dispatcher(&configuration);  // was btCollisionDispatcher
//   contact.attach(dispatcher);                                // as before
//
// Manifolds, their order and every bit in them equal those of btCollisionDispatcher, for any number
// of threads. Pairs are searched ahead of Bullet's serial walk over them. The walk takes a result
// if the query has not changed since, and otherwise searches again. Where Bullet's near callback is
// the default, no contact callback is set and no soft body is near, manifolds are written ahead,
// too; callbacks come from
// the walk, in its order and on its thread.
//
// With an OpenCL device all pairs of a step that need a search are one batch:
//
//   cloudcontact::CloudDispatcher dispatcher(&configuration, {.backend = Backend::OpenCl});
//
// What has no kernels is searched by the CPU in the same step: pairs with a hull, triangles,
// tissues or stated base vectors, edges of a box, cylinder or cone that touch, and bodies that
// nearly touch. The bits do not depend on the backend.
#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <cloudcontact/device/backend.h>

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace cloudcontact {

class AheadPair;
class LookAhead;

// Where a step's pairs are searched.
struct CloudDispatcherSettings {
  int threads = 0;  // includes the caller's; 0: all cores; 1 without a device: no search ahead
  Backend backend = Backend::Cpu;
  // A step with fewer pairs to search does not pay for a device's launches, and stays on the CPU.
  std::size_t leastForDevice = 32;
  bool timing = false;  // times each kernel and copy, which slows the steps down
};

// Since the dispatcher was made.
struct CloudDispatcherStatistics {
  std::size_t ahead = 0;    // pairs searched ahead of Bullet's walk
  std::size_t taken = 0;    // results of these that the walk used
  std::size_t written = 0;  // pairs whose manifolds were written ahead of the walk, too
  // Of the steps that used the device, summed; `shapes` and other reasons count the pairs that the
  // CPU searched in these steps.
  BatchReport device;
  std::size_t deviceSteps = 0;
  std::string deviceFailure;  // why the device is no longer used
};

class CloudDispatcher : public btCollisionDispatcher {
 public:
  // `threads` includes the caller's; 0: all cores; 1: no search ahead. Throws std::invalid_argument
  // if it is negative.
  explicit CloudDispatcher(btCollisionConfiguration* configuration, int threads = 0);
  // Throws std::invalid_argument for negative threads, and std::runtime_error that says what to do
  // if `backend` asks for a device and none computes the same bits as the CPU. A device that fails
  // later is not used any more; the CPU takes over (CloudDispatcherStatistics::deviceFailure).
  CloudDispatcher(btCollisionConfiguration* configuration, const CloudDispatcherSettings& settings);
  ~CloudDispatcher() override;

  int threads() const;
  std::string device() const;                       // name of the device in use; empty: none
  std::map<std::string, DeviceTime> deviceTimes();  // since the last call; needs settings.timing
  CloudDispatcherStatistics statistics() const;

  // With Bullet's own near callback all pairs are searched ahead; with another one, those that it
  // processed in the step before, as are the children of compounds. needsCollision() may be called
  // twice per pair, and for different pairs at the same time.
  void dispatchAllCollisionPairs(btOverlappingPairCache* pairs, const btDispatcherInfo& info,
                                 btDispatcher* dispatcher) override;

 private:
  friend class CloudAlgorithm;
  struct Gathered;
  Gathered look(const btBroadphasePair& pair);
  AheadPair* madeFor(btBroadphasePair& pair);
  bool gather(btOverlappingPairCache& pairs, const btDispatcherInfo& info);
  void walk(btOverlappingPairCache& pairs, const btDispatcherInfo& info);

  std::unique_ptr<LookAhead> lookAhead_;
  std::vector<Gathered> gathered_;  // of each pair, in a step
};

}  // namespace cloudcontact
