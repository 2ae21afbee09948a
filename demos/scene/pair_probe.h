// One pair of Bullet shapes whose narrow phase is run, read and timed alone: no world, no solver.
#pragma once

#include <btBulletDynamicsCommon.h>
#include <cloudcontact/base/pose.h>
#include <cloudcontact/bullet/cloud_contact.h>

#include <memory>
#include <vector>

#include "io/options.h"

namespace cloudcontact::program {

// A point of a manifold, in the world and in double.
struct ProbedPoint {
  Vec3 position = Vec3::Zero();       // midway between the surfaces [m]
  Vec3 normal = Vec3::UnitZ();        // from A to B
  double depth = 0;                   // [m] positive inside
  double stiffness = 0, damping = 0;  // as the algorithm set them; 0 where it did not
  int manifold = 0;
};

class PairProbe {
 public:
  // A stands at the origin, B at `pose`, moving by `motion`. The shapes are not owned. For
  // Method::Cloud `settings` say the law.
  PairProbe(btCollisionShape& a, btCollisionShape& b, const Pose& pose, const Motion& motion,
            Method method, const CloudContactSettings& settings);
  ~PairProbe();
  PairProbe(const PairProbe&) = delete;
  PairProbe& operator=(const PairProbe&) = delete;

  // What one processCollision of a fresh algorithm reports, touching or not.
  std::vector<ProbedPoint> points();

  // Microseconds of each of `repeat` calls of processCollision, B moved by `jitter` [m] in another
  // direction before each, so that nothing is answered from memory; nor is a cloud's query where
  // the settings' `lists` are off. One call more runs first,
  // untimed: it allocates.
  std::vector<double> microseconds(int repeat, double jitter);

 private:
  class Algorithm;

  Pose pose_;
  CloudContact seam_;  // outlives the dispatcher
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  std::unique_ptr<btRigidBody> a_, b_;
};

}  // namespace cloudcontact::program
