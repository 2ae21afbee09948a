// The law of a pair of Bullet objects: which one it gets in a step, and what it keeps between
// steps.
#pragma once

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <cloudcontact/bullet/cloud_contact_settings.h>
#include <cloudcontact/contact/contact.h>
#include <cloudcontact/law/automatic_spring.h>

#include <array>
#include <optional>
#include <vector>

struct btCollisionObjectWrapper;

namespace cloudcontact {

struct Touch;  // first_touch.h

// The law of one pair for one step.
struct PairLaw {
  Law shared = KelvinVoigt{};  // ContactSettings::law: KelvinVoigt, Foundation or Rigid
  // Set if no body states a stiffness. The points' stiffnesses are then their shares of it.
  std::optional<AutomaticSpring> automatic;
  // A law with a memory, from the settings or a shape, or null. The points share it likewise.
  const Law* remembering = nullptr;
  // Each body's tissues, or null: then k and c follow from what the patches touch. A body beside
  // one with tissues may have a spring instead.
  const TissueTable* tissues[2] = {nullptr, nullptr};
  std::optional<KelvinVoigt> springs[2] = {};
};

// A query may come before the world's first step, when Bullet does not know the step's length.
inline double knownStep(double step) {
  return step > 0 ? step : 1.0 / 60;
}

// The settings' law, else one body's own law, else the bodies' tissues or springs in series, else
// an automatic spring. Rigid if neither body can move: there is nothing to push, but queries still
// want the points. Throws std::runtime_error if both bodies state laws that cannot be put in
// series.
PairLaw lawOf(const CloudContactSettings& settings, const btCollisionObjectWrapper& a,
              const btCollisionObjectWrapper& b, double voxel, double step);

// Foundation{}: stiffness and damping come from the bodies (CloudContactSettings::law).
bool takesBodiesSprings(const Law& law);

// What is wrong with the material that Bullet keeps for the object: a friction, restitution,
// stiffness or damping that is NaN, infinite or negative. Null if nothing is.
const char* wrongMaterial(const btCollisionObject& object);

// 1/kg; 0 for an object that contacts do not move.
double inverseMass(const btCollisionObject& object);

// The two bodies in Bullet's order, and how they move.
struct PairSides {
  const btCollisionObjectWrapper* wrapA = nullptr;
  const btCollisionObjectWrapper* wrapB = nullptr;
  Motion motionA, motionB;
  double mass = 0;               // [kg] 1 / (1/mA + 1/mB); 0 if neither moves
  const Touch* touch = nullptr;  // of a swept pair: the contact is found where it touches later
};

// The state of a pair's law with a memory, and the k and c that make Bullet's rows follow it.
//
// The pair has one spring at one depth, the mean of its points' depths weighted by their shares
// (ContactPoint::stiffness, which add up to 1). A row's impulse is step (k (depth + step v) + c v).
// The law's line over the step, force + grip v, is shared out so that no point pulls while others
// push: its force in proportion to the depths, its grip in proportion to the shares. Hence
// k = force / depth and c = grip - step k. c is negative where the law has relaxed, but step k + c,
// which Bullet divides by, is not.
class PairMemory {
 public:
  // The row for a step of `step` seconds that begins with this contact. Bullet also looks for
  // contacts without stepping (performDiscreteCollisionDetection). No time has passed then, which
  // shows in poses, velocities and impulses that equal those at remember().
  KelvinVoigt row(const Law& law, const PairSides& sides, const ContactResult& contact,
                  const std::vector<btPersistentManifold*>& manifolds, double step);
  // Call after the points are written.
  void remember(const PairSides& sides, const std::vector<btPersistentManifold*>& manifolds);
  // For files (base/byte_archive.h).
  template <typename Archive>
  void keepIn(Archive& archive) {
    archive(law_.depth, law_.branchForce, step_);
    for (btScalar& number : fingerprint_) archive(number);
  }

 private:
  using Fingerprint = std::array<btScalar, 37>;
  static Fingerprint fingerprintOf(const PairSides& sides,
                                   const std::vector<btPersistentManifold*>& manifolds);

  LawState law_;
  double step_ = 0;  // [s] the step that began when law_ was updated; 0: none
  Fingerprint fingerprint_{};
};

}  // namespace cloudcontact
