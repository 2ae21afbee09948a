// Runs and times Bullet's narrow phase on one pair of shapes, without a world or a solver.
#pragma once

#include <btBulletDynamicsCommon.h>
#include <cloudcontact/base/pose.h>
#include <cloudcontact/bullet/cloud_contact.h>

#include <memory>
#include <vector>

#include "io/options.h"

namespace cloudcontact::program {

// A point of a manifold, in world coordinates and double.
struct ProbedPoint {
  Vec3 position = Vec3::Zero();       // midway between the surfaces [m]
  Vec3 normal = Vec3::UnitZ();        // from A to B
  double depth = 0;                   // [m] positive inside
  double stiffness = 0, damping = 0;  // as set by the algorithm, else 0
  int manifold = 0;
};

class PairProbe {
 public:
  // A is at the origin, B at `pose` with the velocity `motion`. Does not own the shapes. `settings`
  // apply to clouds.
  PairProbe(btCollisionShape& a, btCollisionShape& b, const Pose& pose, const Motion& motion,
            Method method, const CloudContactSettings& settings);
  ~PairProbe();
  PairProbe(const PairProbe&) = delete;
  PairProbe& operator=(const PairProbe&) = delete;

  // All points that one processCollision of a new algorithm reports, also those that do not touch.
  std::vector<ProbedPoint> points();

  // Microseconds of each of `repeat` calls of processCollision. Before each, B is moved by `jitter`
  // [m] in a new direction, so that no cached result applies; for clouds also switch the settings'
  // `lists` off. One more call runs first, untimed, for allocations.
  std::vector<double> microseconds(int repeat, double jitter);

 private:
  class Algorithm;

  Pose pose_;
  CloudContact seam_;  // must outlive the dispatcher
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  std::unique_ptr<btRigidBody> a_, b_;
};

}  // namespace cloudcontact::program
