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

// Vectors at a patch's points as one rigid motion: their mean, and a turn about the middle.
class RigidVectors {
 public:
  void add(const Vec3& position, const Vec3& vector);
  void fit();  // call after the last add()
  Vec3 at(const Vec3& position) const { return mean_ + spin_.cross(position - center_); }
  const Vec3& mean() const { return mean_; }

 private:
  int count_ = 0;
  Vec3 at_[MANIFOLD_CACHE_SIZE], vectors_[MANIFOLD_CACHE_SIZE];
  Vec3 center_ = Vec3::Zero(), mean_ = Vec3::Zero(), spin_ = Vec3::Zero();
};

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
  double mass_ = 0, limit_ = 0;
  RigidVectors held_;
};

// Sets both directions of a point whose normal is set: along the load, else as in the last step.
void setFrictionDirections(const Vec3& position, const Vec3& slip, const PatchLoad& load,
                           const btManifoldPoint* before, btManifoldPoint& point);

// Moves the standing points of a patch, slower than `slidingSpeed` [m/s], back to their places.
// Without it the residue of the solver's iterations is a creep that never stops. The slip of all
// steps is summed up in m_contactMotion1/2, the rows' target velocities, which take a share of it
// back each step. The targets of all points are one rigid motion: where rows ask for different
// ones, no sweep fulfils them, impulses grow against each other, and a tower of ten falls.
// Not for a sliding patch: a sum that grows while friction is at its limit would pull the body back
// later.
class PatchAnchor {
 public:
  explicit PatchAnchor(double slidingSpeed) : slidingSpeed_(slidingSpeed) {}
  // Adds a point, with last step's point unless it is new.
  void add(const Vec3& position, const Vec3& slip, const btManifoldPoint* before);
  void fit() { back_.fit(); }  // call after the last add()
  // Sets the targets of a point whose friction directions are set.
  void set(const Vec3& position, btManifoldPoint& point) const;

 private:
  double slidingSpeed_;
  RigidVectors back_;
};

}  // namespace cloudcontact
