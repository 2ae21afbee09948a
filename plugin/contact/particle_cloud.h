// Particles against one cloud, step by step: the paper's object 1 as points ("particle groups
// express deformable soft tissue"; docs/method.md, "Step 1: digital objects").
#pragma once

#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/law/automatic_spring.h>

#include <optional>
#include <vector>

#include "contact/particle_matter.h"
#include "contact/particle_solve.h"

namespace cloudcontact {

struct Particle {
  Vec3 start = Vec3::Zero();     // at the start of the step, world [m]
  Vec3 velocity = Vec3::Zero();  // in the step, without contacts and links between particles [m/s]
  double inverseMass = 0;        // [1/kg] 0: pinned
  double share = 0;              // of the pair's law; for a law per area, the area [m^2]
  // Its own k and c, where ParticleSettings::touched gives the cloud's; empty: rigid.
  std::optional<KelvinVoigt> spring = {};
};

// The cloud's body at the start of the step.
struct ParticleBody {
  const SurfaceField* field = nullptr;
  Pose pose;                   // of the cloud
  Vec3 center = Vec3::Zero();  // of mass, world
  RigidResponse response;      // with its current velocities
  Vec3 pull = Vec3::Zero();    // change of its velocity by forces in this step [m/s]
};

struct ParticleSettings {
  double step = 0;  // [s]
  double friction = 0;
  const Law* law =
      nullptr;         // the pair's; null: `touched`, or an automatic spring for each particle
  double gravity = 0;  // [m/s^2] that loads automatic springs
  // With tissues, or a paper body: k and c are those that each particle touches in series with its
  // own, unless `law` is given, and its direction is that of the base vectors.
  const TouchedCloud* touched = nullptr;
};

// It keeps its memory between calls: a step after the first allocates nothing.
class ParticleCloud {
 public:
  // Returns the particles that touch, or will within the step, with their impulses, in the order of
  // the particles. linearChange() and angularChange() are the body's part. Call it once a step.
  const std::vector<ParticleContact>& step(const std::vector<Particle>& particles,
                                           const ParticleBody& body,
                                           const ParticleSettings& settings);
  // The changes of the body's velocities in the last step.
  const Vec3& linearChange() const { return linearChange_; }
  const Vec3& angularChange() const { return angularChange_; }
  void forget();

 private:
  // The last step of one particle.
  struct Memory {
    LawState state;
    Vec3 local = Vec3::Zero(), normal = Vec3::Zero();  // the plane that it is behind, body's frame
    double depth = 0;                                  // [m] under that plane
    Vec3 start = Vec3::Zero(),
         after = Vec3::Zero();   // its start, and its velocity with impulses
    Vec3 others = Vec3::Zero();  // change of its velocity by everything but contact
    bool near = false;           // it had a plane
  };
  struct Plane {
    double depth;  // [m]
    Vec3 normal;   // body's frame
  };

  std::optional<Plane> planeOf(const Vec3& local, const Vec3& end, const ParticleBody& body,
                               const Memory& memory) const;
  LawTangent lineOf(const Particle& particle, const ParticleBody& body,
                    const std::optional<KelvinVoigt>& spring, double depth, double closing,
                    Memory& memory, const ParticleSettings& settings) const;
  LawTangent shareOf(const Law& law, double share, double depth, double closing, Memory& memory,
                     double step) const;
  void expectOfBody(const ParticleBody& body);

  std::vector<Memory> memory_;
  std::vector<ParticleContact> contacts_;
  double step_ = 0;         // [s] the last step; 0: none
  RigidResponse expected_;  // the body, with the expected effect of everything but contact
  Vec3 linearAfter_, angularAfter_, linearOthers_, angularOthers_;
  Vec3 linearChange_ = Vec3::Zero(), angularChange_ = Vec3::Zero();
};

}  // namespace cloudcontact
