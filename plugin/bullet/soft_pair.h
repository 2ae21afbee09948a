// A soft body as particles, and back: between Bullet's nodes and ParticleCloud.
#pragma once

#include <BulletSoftBody/btSoftBody.h>
#include <cloudcontact/bullet/soft_contact_point.h>

#include <vector>

#include "bullet/pair_law.h"
#include "contact/particle_cloud.h"

namespace cloudcontact {

// The cloud's side of the pair.
struct SoftOpponent {
  const btCollisionObjectWrapper* wrap = nullptr;
  btRigidBody* rigid = nullptr;  // null: a collision object or a link, which nothing moves
};

// One soft body against one cloud, from step to step.
class SoftPair {
 public:
  // Throws std::runtime_error where the soft body cannot touch, which says why.
  void step(btSoftBody& soft, const SoftOpponent& opponent, const PairLaw& law);
  void noContact() { contacts_ = nullptr; }
  const std::vector<ParticleContact>* contacts() const { return contacts_; }
  void tell(std::vector<SoftContactPoint>& points) const;

 private:
  void share(const btSoftBody& soft, bool byArea);
  void read(btSoftBody& soft);
  void write(btSoftBody& soft, const SoftOpponent& opponent) const;

  struct Shape {  // what shares depend on
    int nodes = -1, links = -1, faces = -1;
    bool byArea = false;
    bool operator==(const Shape&) const = default;
  };
  Shape shape_;
  std::vector<Particle> particles_;
  ParticleCloud cloud_;
  const std::vector<ParticleContact>* contacts_ = nullptr;
  Vec3 center_ = Vec3::Zero();
};

// Throws std::runtime_error where the soft body moves by other rules than
// btSoftRigidDynamicsWorld's.
void checkSolver(btSoftBody& soft);

// Whether a soft body has been stepped since the last call for this opponent (and this child of
// it): Bullet also looks for contacts between steps, when nodes must not be pushed. A step empties
// a soft body's list of rigid contacts; a mark is put there, of no effect in Bullet's solver.
bool steppedSince(btSoftBody& soft, const btCollisionObjectWrapper& opponent);

}  // namespace cloudcontact
