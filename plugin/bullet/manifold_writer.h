// A pair's contact points into Bullet's persistent manifolds, a manifold a patch.
#pragma once

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <cloudcontact/contact/contact.h>
#include <cloudcontact/law/automatic_spring.h>

#include <optional>
#include <vector>

class btDispatcher;
struct btCollisionObjectWrapper;

namespace cloudcontact {

// The two bodies in Bullet's order, and how they move.
struct PairSides {
  const btCollisionObjectWrapper* wrapA = nullptr;
  const btCollisionObjectWrapper* wrapB = nullptr;
  Motion motionA, motionB;
  double mass = 0;  // [kg] 1 / (1/mA + 1/mB); 0 where neither moves
};

// What a step adds to the points themselves.
struct WriteSettings {
  bool rigid = false;       // no spring: bare contact rows
  double slidingSpeed = 0;  // [m/s] slower than this, a point stands and keeps its place
  double step = 0;          // [s]
  // The points' stiffnesses are their parts of this spring; empty: they are what they say.
  std::optional<AutomaticSpring> automatic;
  // Or their parts of these k and c, for such a law as remembers (pair_memory.h).
  std::optional<KelvinVoigt> shared;
};

// The manifolds of one pair, kept from its first contact until the algorithm dies. Points are
// written anew every step; what the solver learnt of a point (impulses, friction directions,
// lifetime, user data) follows its id, from whichever manifold held it.
class ManifoldWriter {
 public:
  explicit ManifoldWriter(btDispatcher& dispatcher) : dispatcher_(dispatcher) {}
  ~ManifoldWriter();
  ManifoldWriter(const ManifoldWriter&) = delete;
  ManifoldWriter& operator=(const ManifoldWriter&) = delete;

  // Tells gContactStarted/Added/Processed/Destroyed/EndedCallback what Bullet's own algorithms
  // would.
  void write(const PairSides& sides, const ContactResult& contact, const WriteSettings& settings);

  // No contacts any more; the manifolds stay.
  void clear();

  const std::vector<btPersistentManifold*>& manifolds() const { return manifolds_; }

 private:
  void remember();
  const btManifoldPoint* heirOf(int id);
  void fill(btPersistentManifold& manifold, const PairSides& sides, const ContactResult& contact,
            const Patch& patch, const btManifoldPoint& common, const WriteSettings& settings);
  void dropWithoutHeir();

  btDispatcher& dispatcher_;
  std::vector<btPersistentManifold*> manifolds_;
  std::vector<btManifoldPoint> old_;      // last step's points by id
  std::vector<char> inherited_;           // which of them live on
  std::optional<SpringTangent> tangent_;  // of WriteSettings::automatic, per part of a point
};

}  // namespace cloudcontact
