// What a pair with a viscoelastic law remembers from step to step, and the k and c that make
// Bullet's rows carry such a law.
#pragma once

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <cloudcontact/contact/contact.h>
#include <cloudcontact/law/law.h>

#include <array>
#include <vector>

namespace cloudcontact {

struct PairSides;

// The pair's law is one spring, dashpots and all, at the pair's depth: that of its points together,
// each by its share (ContactPoint::stiffness, which add up to 1).
//
// A row's impulse is step (k (depth + step v) + c v). The law's line, force + grip v, is shared out
// so: its force like the depths, so that no point is asked to pull where others push; its grip like
// the shares. Hence k = force / depth and c = grip - step k, which may be negative where the law
// has relaxed; their sum, all that Bullet divides by, is not.
class PairMemory {
 public:
  // For a step of `step` seconds that begins with this contact. Bullet also looks for contacts
  // without stepping (performDiscreteCollisionDetection); then no time has passed, which shows in
  // that no pose, no velocity and no impulse is another than remember() saw.
  KelvinVoigt row(const Law& law, const PairSides& sides, const ContactResult& contact,
                  const std::vector<btPersistentManifold*>& manifolds, double step);
  // After the points are written.
  void remember(const PairSides& sides, const std::vector<btPersistentManifold*>& manifolds);

 private:
  using Print = std::array<btScalar, 37>;
  static Print printOf(const PairSides& sides, const std::vector<btPersistentManifold*>& manifolds);

  LawState state_;
  double step_ = 0;  // [s] the one that began when state_ was last brought up to date; 0: none
  Print print_{};
};

}  // namespace cloudcontact
