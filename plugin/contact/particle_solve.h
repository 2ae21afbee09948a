// Particles that touch a rigid body, each on a law's line and with friction: all their impulses
// over one step, found together.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/law/law.h>

#include <vector>

namespace cloudcontact {

// A rigid body's velocity at the step's end but for these contacts, and how impulses change it.
struct RigidResponse {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();        // world [m/s, rad/s]
  Vec3 inverseMass = Vec3::Zero();                           // along the world's axes [1/kg]
  Eigen::Matrix3d inverseInertia = Eigen::Matrix3d::Zero();  // world [1/(kg m^2)]

  // Both with `arm` from the centre of mass.
  Vec3 at(const Vec3& arm) const { return linear + angular.cross(arm); }
  void push(const Vec3& impulse, const Vec3& arm) {
    linear += inverseMass.cwiseProduct(impulse);
    angular += inverseInertia * arm.cross(impulse);
  }
};

struct ParticleContact {
  int particle = 0;
  Vec3 normal = Vec3::UnitZ();   // world, out of the body
  Vec3 arm = Vec3::Zero();       // world, from the body's centre of mass [m]
  double depth = 0;              // as the step begins [m]; negative: a gap
  LawTangent line;               // its own share of the law
  double inverseMass = 0;        // [1/kg]
  Vec3 velocity = Vec3::Zero();  // as RigidResponse's, then with the impulses [m/s]
  double push = 0;               // found: along the normal, on the particle [N s]
  Vec3 rub = Vec3::Zero();       // found: friction on the particle [N s]

  Vec3 impulse() const { return push * normal + rub; }
};

// Backward Euler: at the step's end every push is what its line says at the rate that all impulses
// together leave, and every rub stops its particle's slip or is friction * push long. `body` and
// the particles' velocities end up with the impulses in them. Particles and body must be finite.
void solveParticles(std::vector<ParticleContact>& contacts, RigidResponse& body, double friction,
                    double step);

}  // namespace cloudcontact
