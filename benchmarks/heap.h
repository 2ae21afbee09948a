// A Bullet world of nuts in a box, stacked in ten layers or poured. Times its narrow phase and
// steps.
#pragma once

#include <btBulletDynamicsCommon.h>
#include <cloudcontact/bullet/cloud_contact.h>
#include <cloudcontact/bullet/cloud_dispatcher.h>
#include <cloudcontact/bullet/newton_solver.h>

#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace cloudcontact {

struct HeapSettings {
  int bodies = 100;
  double across = 28e-3, height = 13e-3;  // of a body [m], axis z, center at the origin
  double voxel = 1e-3;                    // [m]; also of Bullet's margins
  int threads = 1;                        // CloudDispatcher's
  Backend backend = Backend::Cpu;         // CloudDispatcher's
  bool timing = false;                    // times each kernel
  // Makes one shape for each body; shapes may share data.
  std::function<std::shared_ptr<btCollisionShape>()> shape;
  bool clouds = true;               // the law and world settings for clouds, not Bullet's
  std::vector<btTransform> places;  // on the ground, in place of layers in a box
  bool floats = false;              // `places` without ground and gravity
  double slab = 0;                  // [m] edge of a box as ground of `places`, not a plane
  bool poured = false;              // dropped from a loose block in random orientations
  double mass = 0.03;               // of a body [kg]
  CloudContactSettings contact;
  bool newton = false;  // NewtonSolver, not Bullet's own sweeps
};

// Mean times of the measured steps; counts of the last one.
struct HeapRow {
  int bodies = 0;
  double overlaps = 0, pairs = 0, contacts = 0;  // of boxes; of bodies in contact; points
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
  // Does one step; returns its time [s].
  double step();
  double narrowSeconds() const { return dispatcher_.seconds; }  // of all steps
  CloudDispatcher& dispatcher() { return dispatcher_; }
  Pose pose(int body) const;
  void rest(const Heap& other);             // places all bodies as there, at rest
  std::vector<std::pair<int, int>> near();  // bodies whose boxes overlap
  double fastest() const;                   // speed of the fastest point of any body [m/s]
  double energy() const;                    // of all bodies, kinetic and of gravity [J]
  CloudContactStatistics statistics() const { return contact_.statistics(); }
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
  void addSlab(double edge);
  void addGround(std::shared_ptr<btCollisionShape> shape, const btTransform& place);
  void addBody(const HeapSettings& settings, const btTransform& place);
  void lay(const HeapSettings& settings);
  void pour(const HeapSettings& settings);
  void count(HeapRow& row);

  double reach_ = 0;  // radius of a body's bounding sphere
  CloudContact contact_;
  btDefaultCollisionConfiguration configuration_;
  TimedDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  NewtonSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<std::shared_ptr<btCollisionShape>> shapes_, planes_;
  std::vector<std::unique_ptr<btRigidBody>> walls_, bodies_;
};

}  // namespace cloudcontact
