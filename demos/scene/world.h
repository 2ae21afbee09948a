// A scene as a running Bullet world.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/options.h"
#include "scene/drawn_body.h"
#include "scene/penetration.h"
#include "scene/scene.h"

namespace cloudcontact::program {

struct ShapeStore;  // shape_store.h

struct WorldSettings {
  CommonOptions common;
  double voxel = 0;                        // [m], must be set
  int iterations = 10;                     // of the solver, Bullet's own default
  bool sleep = false;                      // bodies at rest may fall asleep
  std::shared_ptr<ShapeStore> store = {};  // of worlds that share their bodies' clouds
};

// A body's state, in the scene body's own frame.
struct BodyState {
  Pose pose;
  Vec3 linearVelocity = Vec3::Zero();  // of the frame's origin [m/s]
  Vec3 angularVelocity = Vec3::Zero();
  bool asleep = false;
};

// What is stored in a scene [J]. The springs are told apart: a body that arrives between two steps
// finds its spring loaded by the way it went unseen (v h deep), which no body ever had and damping
// takes again, so their sum may stand above the start's energy though no body gains any.
struct Energy {
  double kinetic = 0;
  double potential = 0;  // in gravity, zero at the world's origin
  double spring = 0;     // in the contacts: k d^2 / 2 of each that has a stiffness
  double ofBodies() const { return kinetic + potential; }
};

// What the latest narrow phase found; energy is that of the step's start, which the contacts'
// depths belong to.
struct ContactMoment {
  Energy energy;
  int pairs = 0;       // of bodies that have contacts
  int contacts = 0;    // points
  double deepest = 0;  // of them, as the method under test sees it [m]
};

// One point. `force` is what the solver let body a press on body b with during the latest step,
// friction with it, as a mean over that step [N].
struct ContactNow {
  Vec3 position = Vec3::Zero();  // midway between the surfaces, moved on with the bodies [m]
  Vec3 normal = Vec3::UnitZ();   // from a to b
  Vec3 force = Vec3::Zero();
  double depth = 0;  // [m] positive inside, at the step's start
};

// One manifold: with clouds a patch of the pair's contact.
struct PatchNow {
  int a = -1, b = -1;                 // btCollisionObject::getUserIndex
  std::size_t first = 0, points = 0;  // of all points
};

struct ContactsNow {
  std::vector<PatchNow> patches;
  std::vector<ContactNow> points;  // of all patches, in their order

  std::span<const ContactNow> of(const PatchNow& patch) const {
    return {points.data() + patch.first, patch.points};
  }
};

class World {
 public:
  // Throws BadInput naming the body, file or option that cannot be used.
  World(const SceneDescription& scene, const WorldSettings& settings);
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  // Throws WorkFailed where a state is no longer finite.
  void step(double seconds);
  // Looks for contacts where bodies stand now, without a step.
  void findContacts();

  std::size_t bodyCount() const;
  const std::string& name(std::size_t body) const;
  bool isStatic(std::size_t body) const;
  BodyState state(std::size_t body) const;
  const Pose& pose(std::size_t body) const;  // state's; worked out once a step
  const ContactMoment& moment() const;
  // As they stand after the latest step; none before the first.
  void contacts(ContactsNow& now) const;
  const DrawnBody& drawn(std::size_t body) const;
  double mass(std::size_t body) const;  // [kg], 0 for a static body

  // The deepest that any two bodies which may touch stand in each other now [m].
  double penetration() const;
  // What penetration() costs: probes looked up.
  std::size_t probes() const;

  double narrowPhaseSeconds() const;
  double solverSeconds() const;
  // FNV-1a over the bits of all states: equal runs, equal hash.
  std::uint64_t hash() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace cloudcontact::program
