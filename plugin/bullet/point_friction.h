// Directions of a point's friction rows, and anchors of standing points.
//
// Bullet clamps a point's two friction rows separately, to a square whose corners reach beyond
// Coulomb's circle. Square and circle agree if the first row is along the friction force, so its
// direction is predicted: from the slip, which friction must stop, and from the load, which it must
// hold. The load is last step's friction as one force and one torque of the whole patch, spread
// over its points. A single point's last force is no good prediction, because points pull against
// one another; nor is slip alone, which at the edge of sliding is smaller than the solver's
// residue.
#pragma once

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <cloudcontact/contact/contact.h>

namespace cloudcontact {

// Velocity of A's surface over B's at a point [m/s].
Vec3 slipOf(const ContactPoint& point, const Motion& a, const Motion& b);

// The friction of a patch's points in the last step.
class PatchLoad {
 public:
  // Adds a point, with last step's point unless it is new.
  void add(const Vec3& position, const btManifoldPoint* before);
  // Call after the last add(); `mass` is a point's share of the pair's effective mass [kg].
  void sum(double mass);
  // The direction in which A would move over B without friction; zero if friction is far from its
  // limit, so that its rows need not turn.
  Vec3 at(const Vec3& position, const Vec3& slip) const;
  // Whether friction was at its limit.
  bool slides() const;

 private:
  int count_ = 0;
  Vec3 at_[MANIFOLD_CACHE_SIZE], held_[MANIFOLD_CACHE_SIZE];
  double mass_ = 0, limit_ = 0;
  Vec3 center_ = Vec3::Zero(), force_ = Vec3::Zero(), spin_ = Vec3::Zero();
};

// Sets both directions of a point whose normal is set: along the load, else as in the last step.
void setFrictionDirections(const Vec3& position, const Vec3& slip, const PatchLoad& load,
                           const btManifoldPoint* before, btManifoldPoint& point);

// Moves a standing point, slower than `slidingSpeed` [m/s], back to its place. Without it the
// residue of the solver's iterations is a creep that never stops. The slip of all steps is summed
// up in m_contactMotion1/2, the rows' target velocities, which take a share of it back each step.
// Not for a sliding patch: a sum that grows while friction is at its limit would pull the body back
// later.
void anchor(const Vec3& slip, const btManifoldPoint* before, double slidingSpeed,
            btManifoldPoint& point);

}  // namespace cloudcontact
