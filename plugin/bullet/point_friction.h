// Directions of a point's friction rows, and the springs that hold it.
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

 private:
  int count_ = 0;
  double mass_ = 0, limit_ = 0;
  RigidVectors held_;
};

// Sets both directions of a point whose normal is set: along the load, else as in the last step.
void setFrictionDirections(const Vec3& position, const Vec3& slip, const PatchLoad& load,
                           const btManifoldPoint* before, btManifoldPoint& point);

// The spring and dashpot that hold a point along its surface, in series with a slider that gives
// way at Coulomb's limit (Cundall and Strack 1979). A step gives them backward in time, as Bullet's
// row of the weight step (step k + c). Rigid rows in their place have no solution, as a patch's
// points hold more than its bodies have motions, and what they leave is a creep.
struct FrictionSpring {
  double weight = 0;  // [kg] 0: none
  double back = 0;    // [1/s] of its stretch, the speed at which it would be no force

  // Of a written point between bodies of this mass (PairSides::mass) [kg]: as its normal's spring,
  // but kTangent times as stiff as that or as the bodies' mass, whichever is more. What a body
  // slides before its friction is whole is then a tenth of friction times depth or what it falls in
  // a step. With the normal's own stiffness, a block on a slope of just its friction runs ahead by
  // 0.05 m.
  static constexpr double kTangent = 10;
  static FrictionSpring of(const btManifoldPoint& point, double mass, double step);

  // How far a point is stretched [m] that was stretched as it says, by the slip since [m/s] or, at
  // Coulomb's limit, by the friction that it had.
  Vec3 stretched(const btManifoldPoint& point, const Vec3& slip, double step) const;
  // Sets a point's target velocities, in which it keeps how far it is stretched, and the softness
  // for Bullet's own solver.
  void write(const Vec3& stretch, double mass, btManifoldPoint& point) const;
};

}  // namespace cloudcontact
