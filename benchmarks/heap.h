// Nuts in a box, laid ten layers deep, each on those below, or poured: a Bullet world whose narrow
// phase and step are timed.
#pragma once

#include <btBulletDynamicsCommon.h>
#include <cloudcontact/bullet/cloud_contact.h>
#include <cloudcontact/bullet/cloud_dispatcher.h>

#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace cloudcontact {

struct HeapSettings {
  int bodies = 100;
  double across = 28e-3, height = 13e-3;  // of a body [m], axis z, its middle at the origin
  double voxel = 1e-3;                    // what lengths are measured by [m]
  int threads = 1;                        // CloudDispatcher's
  // One shape a body; equal bodies may share what it holds.
  std::function<std::shared_ptr<btCollisionShape>()> shape;
  bool clouds = true;   // the law and the settings for clouds; else Bullet's own
  bool poured = false;  // let fall from a loose block, turned every way
  double mass = 0.03;   // of a body [kg]
};

// Times are means over the measured steps, counts those of the last.
struct HeapRow {
  int bodies = 0;
  double overlaps = 0, pairs = 0, contacts = 0;  // of boxes; that have contacts; points
  double stepSeconds = 0, narrowSeconds = 0;
  double deepest = 0;  // of any contact [m]
};

class Heap {
 public:
  explicit Heap(const HeapSettings& settings);
  ~Heap();
  Heap(const Heap&) = delete;
  Heap& operator=(const Heap&) = delete;

  HeapRow run(int settle, int measured);
  // One step; its time [s].
  double step();
  // Bodies' places, bodies whose boxes overlap, and the fastest point's speed of any body [m/s].
  Pose pose(int body) const;
  std::vector<std::pair<int, int>> near();
  double fastest() const;
  const std::vector<std::shared_ptr<btCollisionShape>>& shapes() const { return shapes_; }

 private:
  class TimedDispatcher : public CloudDispatcher {
   public:
    using CloudDispatcher::CloudDispatcher;
    void dispatchAllCollisionPairs(btOverlappingPairCache* pairs, const btDispatcherInfo& info,
                                   btDispatcher* dispatcher) override;
    double seconds = 0;
  };
  void addWall(const btVector3& normal, double offset);
  void addBody(const HeapSettings& settings, const btTransform& place);
  void lay(const HeapSettings& settings);
  void pour(const HeapSettings& settings);
  void count(HeapRow& row);

  double reach_ = 0;  // of a body's farthest point from its middle
  CloudContact contact_;
  btDefaultCollisionConfiguration configuration_;
  TimedDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<std::shared_ptr<btCollisionShape>> shapes_, planes_;
  std::vector<std::unique_ptr<btRigidBody>> walls_, bodies_;
};

}  // namespace cloudcontact
