// SoftPair: steps one soft body against one cloud, with the soft body's nodes as particles.
#pragma once

#include <BulletSoftBody/btSoftBody.h>
#include <cloudcontact/bullet/soft_contact_point.h>

#include <memory>
#include <vector>

#include "bullet/pair_law.h"
#include "bullet/tissue_body.h"
#include "contact/particle_cloud.h"

namespace cloudcontact {

// The cloud's side of the pair.
struct SoftOpponent {
  const btCollisionObjectWrapper* wrap = nullptr;
  btRigidBody* rigid = nullptr;  // null: a collision object or a link, which is not moved
};

class SoftPair {
 public:
  // Throws std::runtime_error, which says why, if the soft body cannot touch.
  // `vectors`: directions are those of the cloud's base vectors.
  void step(btSoftBody& soft, const SoftOpponent& opponent, const PairLaw& law, bool vectors);
  void noContact() { contacts_ = nullptr; }
  const std::vector<ParticleContact>* contacts() const { return contacts_; }
  void append(std::vector<SoftContactPoint>& points) const;

 private:
  void share(const btSoftBody& soft, bool byArea);
  void shareTissue(const TissueBody& tissue, bool byArea);
  void touch(const btSoftBody& soft, const SoftOpponent& opponent, const PairLaw& law,
             bool vectors);
  void read(btSoftBody& soft);
  void write(btSoftBody& soft, const SoftOpponent& opponent) const;

  struct Shape {  // what the nodes' shares depend on
    int nodes = -1, links = -1, faces = -1, cuts = -1;
    bool byArea = false;
    bool operator==(const Shape&) const = default;
  };
  Shape shape_;
  std::vector<Particle> particles_;
  ParticleCloud cloud_;
  TouchedCloud touched_;
  std::shared_ptr<const PaperBody> paper_;
  const std::vector<ParticleContact>* contacts_ = nullptr;
  Vec3 center_ = Vec3::Zero();
  const btCollisionObject* other_ = nullptr;
};

// Why clouds do not touch the soft body; null if they do: it belongs to a btSoftRigidDynamicsWorld
// or a btSoftMultiBodyDynamicsWorld.
const char* wrongSoft(const btSoftBody& soft);
void validate(const btSoftBody& soft);  // throws std::runtime_error if there is a reason

// Whether a soft body was stepped since the last call for this opponent (or this child of a
// compound). Bullet also looks for contacts between steps, when nodes must not be pushed. A step
// empties the soft body's list of rigid contacts, so the function leaves a mark there, which has no
// effect in Bullet's solver.
bool steppedSince(btSoftBody& soft, const btCollisionObjectWrapper& opponent);

}  // namespace cloudcontact
