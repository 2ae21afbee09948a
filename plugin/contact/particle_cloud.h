// A crowd of particles against one cloud, from step to step: the paper's object 1 as points
// (paper, step 1: "particle groups express deformable soft tissue").
#pragma once

#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/law/automatic_spring.h>

#include <optional>
#include <vector>

#include "contact/particle_solve.h"

namespace cloudcontact {

struct Particle {
  Vec3 start = Vec3::Zero();     // world, as the step begins [m]
  Vec3 velocity = Vec3::Zero();  // over the step, but for contacts and for what binds particles
  double inverseMass = 0;        // [1/kg] 0: pinned
  double share = 0;              // of the pair's law; of a law per area, the area [m^2]
};

// The cloud's body as the step begins.
struct ParticleBody {
  const SurfaceField* field = nullptr;
  Pose pose;                   // of the cloud
  Vec3 center = Vec3::Zero();  // of mass, world
  RigidResponse response;      // velocities as they are now
  Vec3 pull = Vec3::Zero();    // what forces will add to its velocity in this step [m/s]
};

struct ParticleSettings {
  double step = 0;  // [s]
  double friction = 0;
  const Law* law = nullptr;  // the pair's, or null: an automatic spring a particle
  double gravity = 0;        // [m/s^2] what weighs on automatic springs
};

// Keeps its memory between calls: a step after the first allocates nothing.
class ParticleCloud {
 public:
  // Those that touch or will within the step, with their impulses, in the particles' order; the
  // body's answer to them is what `body.response` says afterwards of its velocities, less `before`.
  // Call it once a step.
  const std::vector<ParticleContact>& step(const std::vector<Particle>& particles,
                                           const ParticleBody& body,
                                           const ParticleSettings& settings);
  // What the last step changed of the body's velocities.
  const Vec3& linearChange() const { return linearChange_; }
  const Vec3& angularChange() const { return angularChange_; }
  void forget();

 private:
  // Of one particle.
  struct Memory {
    LawState state;
    Vec3 local = Vec3::Zero(), normal = Vec3::Zero();  // body's frame: the plane that it is behind
    double depth = 0;                                  // [m] under that plane
    Vec3 start = Vec3::Zero(),
         after = Vec3::Zero();   // the last step's start, velocity with impulses
    Vec3 others = Vec3::Zero();  // what all else did to it in the step before
    bool near = false;           // in the last step
  };
  struct Plane {
    double depth;  // [m]
    Vec3 normal;   // body's frame
  };

  std::optional<Plane> planeOf(const Vec3& local, const Vec3& end, const ParticleBody& body,
                               const Memory& memory) const;
  LawTangent lineOf(const Particle& particle, const ParticleBody& body, double depth,
                    double closing, Memory& memory, const ParticleSettings& settings) const;
  void expectOfBody(const ParticleBody& body);

  std::vector<Memory> memory_;
  std::vector<ParticleContact> contacts_;
  double step_ = 0;         // [s] the last one; 0: none to remember
  RigidResponse expected_;  // the body, with what else will happen to it
  Vec3 linearAfter_, angularAfter_, linearOthers_, angularOthers_;
  Vec3 linearChange_ = Vec3::Zero(), angularChange_ = Vec3::Zero();
};

}  // namespace cloudcontact
