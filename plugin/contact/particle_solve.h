// Solves the impulses between particles and a rigid body over one step, with friction.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/law/law.h>

#include <vector>

namespace cloudcontact {

// A rigid body's velocity at the end of the step without these contacts, and its inverse mass.
struct RigidResponse {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();        // world [m/s, rad/s]
  Vec3 inverseMass = Vec3::Zero();                           // along the world's axes [1/kg]
  Eigen::Matrix3d inverseInertia = Eigen::Matrix3d::Zero();  // world [1/(kg m^2)]

  // `arm`: from the center of mass [m].
  Vec3 at(const Vec3& arm) const { return linear + angular.cross(arm); }
  void push(const Vec3& impulse, const Vec3& arm) {
    linear += inverseMass.cwiseProduct(impulse);
    angular += inverseInertia * arm.cross(impulse);
  }
};

struct ParticleContact {
  int particle = 0;
  Vec3 normal = Vec3::UnitZ();   // world, out of the body
  Vec3 arm = Vec3::Zero();       // world, from the body's center of mass [m]
  double depth = 0;              // at the start of the step [m]; negative: a gap
  LawTangent line;               // its share of the law, linear in the rate
  double inverseMass = 0;        // [1/kg]
  Vec3 velocity = Vec3::Zero();  // as in RigidResponse; the solver adds impulses [m/s]
  double push = 0;               // result: along the normal, on the particle [N s]
  Vec3 rub = Vec3::Zero();       // result: friction on the particle [N s]

  Vec3 impulse() const { return push * normal + rub; }
};

// Solves one step by backward Euler. At its end every push follows its line at the rate that all
// impulses leave, and every rub stops its particle's slip or has the size friction * push. Adds the
// impulses to the velocities of `body` and of the particles. All input must be finite.
void solveParticles(std::vector<ParticleContact>& contacts, RigidResponse& body, double friction,
                    double step);

}  // namespace cloudcontact
