// Which way a point's friction acts, and how a standing point keeps its place.
//
// Bullet clamps a point's two friction rows each for itself: a square, whose corners reach 1.41
// times as far as Coulomb's circle. Where the first row lies along the force, square and circle
// touch. The force to come is foretold from the slip, which friction must stop, and from the load,
// which it must hold: what it carried last step, as one force and one spin of the whole patch, laid
// over its points. Each point's own last force will not do: points pull against one another, and
// rows that turn to face that swing by 45 degrees to and fro, a stable two-step cycle in which a
// slope holds 3 % too much. Nor will slip alone: at the edge of sliding it is smaller than the
// solver's residue.
#pragma once

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <cloudcontact/contact/contact.h>

namespace cloudcontact {

// How fast A's surface slides over B's at a point [m/s].
Vec3 slipOf(const ContactPoint& point, const Motion& a, const Motion& b);

// What friction carried at a patch's points in the last step.
class PatchLoad {
 public:
  // A point of the patch and, where it is not new, what it was.
  void add(const Vec3& position, const btManifoldPoint* before);
  // After the last point; `mass` is a point's share of the pair's effective mass [kg].
  void sum(double mass);
  // The way that A would move over B at a place without friction; zero where friction is far from
  // its limit, so that its rows need not turn.
  Vec3 at(const Vec3& position, const Vec3& slip) const;
  // Friction carried all that it can.
  bool slides() const;

 private:
  int count_ = 0;
  Vec3 at_[MANIFOLD_CACHE_SIZE], held_[MANIFOLD_CACHE_SIZE];
  double mass_ = 0, limit_ = 0;
  Vec3 center_ = Vec3::Zero(), force_ = Vec3::Zero(), spin_ = Vec3::Zero();
};

// Both directions of a point whose normal is written: along the load, else as they were.
void setFrictionDirections(const Vec3& position, const Vec3& slip, const PatchLoad& load,
                           const btManifoldPoint* before, btManifoldPoint& point);

// A standing point, slower than `slidingSpeed` [m/s], goes back to where it stood. Bullet starts
// friction from nothing every step, so what its iterations leave over is a creep that never stops;
// here the slip of all steps is summed up, and a share of it asked back as the rows' target
// velocity, m_contactMotion1/2, in which the sum lives. Not for a patch that slides: a sum that
// goes on while friction holds all it can pulls the body back up the slope later (at 1 kHz a brick
// stood at friction 0.49 on a slope of 0.5, by leaps forward and back).
void anchor(const Vec3& slip, const btManifoldPoint* before, double slidingSpeed,
            btManifoldPoint& point);

}  // namespace cloudcontact
