// ManifoldWriter: writes a pair's contact points into Bullet's persistent manifolds, one per patch.
#pragma once

#include "bullet/step_adjustments.h"

class btDispatcher;

namespace cloudcontact {

class PointLaw;

// The manifolds of one pair, kept from its first contact until the algorithm is deleted. Points are
// rewritten every step. The solver's data of a point (impulses, friction directions, lifetime, user
// data) follows its ID, whichever manifold held it.
class ManifoldWriter {
 public:
  explicit ManifoldWriter(btDispatcher& dispatcher) : dispatcher_(dispatcher) {}
  ~ManifoldWriter();
  ManifoldWriter(const ManifoldWriter&) = delete;
  ManifoldWriter& operator=(const ManifoldWriter&) = delete;

  // Calls gContactStarted/Added/Processed/Destroyed/EndedCallback as Bullet's algorithms do.
  void write(const PairSides& sides, const ContactResult& contact, const WriteSettings& settings);

  // Removes all contacts and keeps the manifolds.
  void clear();

  const std::vector<btPersistentManifold*>& manifolds() const { return manifolds_; }
  std::size_t bytesKept() const {  // without the manifolds
    return manifolds_.capacity() * sizeof(manifolds_[0]) + old_.capacity() * sizeof(old_[0]) +
           inherited_.capacity();
  }
  // As many as `count`, of these bodies; for contacts that are read from a file.
  const std::vector<btPersistentManifold*>& resize(std::size_t count, const btCollisionObject& a,
                                                   const btCollisionObject& b);

 private:
  bool addManifold(const btCollisionObject& a, const btCollisionObject& b);
  void remember();
  const btManifoldPoint* ancestorOf(int id);  // last step's point, once; null for a new point
  void fill(btPersistentManifold& manifold, const PairSides& sides, const ContactResult& contact,
            const Patch& patch, const btManifoldPoint& common, const PointLaw& law,
            const WriteSettings& settings);
  void reportDestroyed();

  btDispatcher& dispatcher_;
  std::vector<btPersistentManifold*> manifolds_;
  std::vector<btManifoldPoint> old_;  // last step's points, sorted by ID
  std::vector<char> inherited_;       // 1 for each of old_ that lives on
  bool waits_ = false;                // StepPoint::waits
};

}  // namespace cloudcontact
