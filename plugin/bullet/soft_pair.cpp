// Nodes to particles, and impulses to nodes.
//
// When Bullet looks for contacts it has already moved the nodes by their velocities, from m_q to
// m_x. Afterwards it moves m_x to satisfy the links, and sets the velocity from m_x - m_q. An
// impulse therefore changes m_v and m_x.
#include "bullet/soft_pair.h"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btSoftBodySolvers.h>
#include <cloudcontact/bullet/cloud_shape.h>

#include <cmath>
#include <stdexcept>

#include "bullet/convert.h"

namespace cloudcontact {

namespace {

constexpr const char* kDeformable =
    "a soft body of a deformable world does not touch clouds: use btSoftRigidDynamicsWorld";
constexpr const char* kBadNode = "a soft body's node is NaN or infinite: it has no contacts";
constexpr const char* kNoArea =
    "a soft body without faces has no area for Foundation: use KelvinVoigt";

ParticleBody bodyOf(const SoftOpponent& opponent, double step) {
  const btCollisionObject& object = *opponent.wrap->getCollisionObject();
  ParticleBody body;
  body.field = &static_cast<const CloudShape*>(opponent.wrap->getCollisionShape())->field();
  body.pose = toPose(opponent.wrap->getWorldTransform());
  body.center = toVec3(object.getWorldTransform().getOrigin());
  if (!opponent.rigid) return body;
  const btRigidBody& rigid = *opponent.rigid;
  RigidResponse& response = body.response;
  response.linear = toVec3(rigid.getLinearVelocity());
  response.angular = toVec3(rigid.getAngularVelocity());
  if (rigid.isStaticOrKinematicObject()) return body;
  response.inverseMass = toVec3(rigid.getLinearFactor()) * double(rigid.getInvMass());
  const btMatrix3x3& inertia = rigid.getInvInertiaTensorWorld();
  for (int row = 0; row < 3; ++row)
    response.inverseInertia.row(row) = rigid.getAngularFactor()[row] * toVec3(inertia[row]);
  body.pull = step * rigid.getInvMass() * toVec3(rigid.getTotalForce());
  return body;
}

bool isFinite(const ParticleBody& body) {
  return body.pose.position.allFinite() && body.pose.orientation.coeffs().allFinite() &&
         body.response.linear.allFinite() && body.response.angular.allFinite();
}

}  // namespace

void SoftPair::share(const btSoftBody& soft, bool byArea) {
  const auto* const tissue = dynamic_cast<const TissueBody*>(&soft);
  const Shape now{soft.m_nodes.size(), soft.m_links.size(), soft.m_faces.size(),
                  tissue ? tissue->cuts : 0, byArea};
  if (now == shape_) return;
  if (tissue) {
    shape_ = now;
    return shareTissue(*tissue, byArea);
  }
  if (byArea && now.faces == 0) throw std::runtime_error(kNoArea);
  particles_.assign(static_cast<std::size_t>(now.nodes), {});
  const auto add = [&](const btSoftBody::Node* node, double part) {
    particles_[static_cast<std::size_t>(node - &soft.m_nodes[0])].share += part;
  };
  double all = 0;
  for (int i = 0; i < now.faces; ++i) {
    const btSoftBody::Face& face = soft.m_faces[i];
    const double area = std::abs(face.m_ra) / 2;  // m_ra is twice the area
    for (const btSoftBody::Node* node : face.m_n) add(node, area / 3);
    all += area;
  }
  for (int i = 0; all == 0 && i < now.links; ++i)
    for (const btSoftBody::Node* node : soft.m_links[i].m_n) add(node, soft.m_links[i].m_rl);
  if (all == 0)
    for (const Particle& p : particles_) all += p.share;
  for (Particle& p : particles_) {
    if (all == 0) p.share = 1.0 / now.nodes;
    if (all > 0 && !byArea) p.share /= all;
  }
  shape_ = now;
}

// By the areas of the surface around the nodes. A cut adds surface, and changes no other node's
// share.
void SoftPair::shareTissue(const TissueBody& tissue, bool byArea) {
  particles_.assign(tissue.areas.size(), {});
  for (std::size_t i = 0; i < tissue.areas.size(); ++i)
    particles_[i].share = byArea ? tissue.areas[i] : tissue.areas[i] / tissue.wholeArea;
}

// Where tissues or base vectors count, each node has what it touches.
void SoftPair::touch(const btSoftBody& soft, const SoftOpponent& opponent, const PairLaw& law,
                     bool vectors) {
  const auto& shape = static_cast<const CloudShape&>(*opponent.wrap->getCollisionShape());
  touched_.tissues = law.tissues[0];
  touched_.spring = law.springs[0];
  touched_.byArea = std::holds_alternative<Foundation>(law.shared);
  const auto paper = vectors ? shape.paper() : nullptr;
  if (paper && paper != paper_)
    touched_.hardness = hardnessOf(paper->vectors->tissues(), paper->hardness);
  paper_ = paper;
  touched_.paper = paper.get();
  const auto* const tissue = dynamic_cast<const TissueBody*>(&soft);
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    particles_[i].spring = law.springs[1];
    if (tissue && law.tissues[1]) particles_[i].spring = tissue->springs[i];
  }
}

void SoftPair::read(btSoftBody& soft) {
  for (int i = 0; i < soft.m_nodes.size(); ++i) {
    const btSoftBody::Node& node = soft.m_nodes[i];
    Particle& p = particles_[static_cast<std::size_t>(i)];
    p.start = toVec3(node.m_q);
    p.velocity = (toVec3(node.m_x) - p.start) / double(soft.m_sst.sdt);
    p.inverseMass = node.m_im;
    if (!p.start.allFinite() || !p.velocity.allFinite()) throw std::runtime_error(kBadNode);
  }
}

void SoftPair::write(btSoftBody& soft, const SoftOpponent& opponent) const {
  for (const ParticleContact& c : *contacts_) {
    btSoftBody::Node& node = soft.m_nodes[c.particle];
    const Vec3 change = c.inverseMass * c.impulse();
    node.m_v += toBullet(change);
    node.m_x += toBullet(Vec3(soft.m_sst.sdt * change));
  }
  if (!opponent.rigid || opponent.rigid->isStaticOrKinematicObject()) return;
  btRigidBody& rigid = *opponent.rigid;
  rigid.setLinearVelocity(rigid.getLinearVelocity() + toBullet(cloud_.linearChange()));
  rigid.setAngularVelocity(rigid.getAngularVelocity() + toBullet(cloud_.angularChange()));
}

void SoftPair::step(btSoftBody& soft, const SoftOpponent& opponent, const PairLaw& law,
                    bool vectors) {
  contacts_ = nullptr;
  ParticleSettings settings;
  settings.step = soft.m_sst.sdt;
  settings.friction = soft.m_cfg.kDF * opponent.wrap->getCollisionObject()->getFriction();
  settings.gravity = soft.getWorldInfo()->m_gravity.length();
  settings.law = law.remembering;
  const bool byMatter = law.tissues[0] || law.tissues[1];
  if (!byMatter && !law.remembering && !law.automatic && !std::holds_alternative<Rigid>(law.shared))
    settings.law = &law.shared;
  share(soft, !law.automatic && std::holds_alternative<Foundation>(law.shared));
  if (byMatter || vectors) {
    touch(soft, opponent, law, vectors);
    settings.touched = &touched_;
  }
  read(soft);
  const ParticleBody body = bodyOf(opponent, settings.step);
  if (!isFinite(body)) throw std::runtime_error("a body's pose is NaN or infinite: no contacts");
  center_ = body.center;
  other_ = opponent.wrap->getCollisionObject();
  contacts_ = &cloud_.step(particles_, body, settings);
  write(soft, opponent);
}

void SoftPair::append(std::vector<SoftContactPoint>& points) const {
  if (!contacts_) return;
  for (const ParticleContact& c : *contacts_)
    points.push_back({c.particle, center_ + c.arm, c.normal, c.depth, c.impulse(), other_});
}

const char* wrongSoft(const btSoftBody& soft) {
  // Bullet has no const access to the solver.
  const btSoftBodySolver* const solver = const_cast<btSoftBody&>(soft).getSoftBodySolver();
  return solver && solver->getSolverType() == btSoftBodySolver::DEFAULT_SOLVER ? nullptr
                                                                               : kDeformable;
}

void validate(const btSoftBody& soft) {
  if (const char* const wrong = wrongSoft(soft)) throw std::runtime_error(wrong);
}

bool steppedSince(btSoftBody& soft, const btCollisionObjectWrapper& opponent) {
  if (!(soft.m_sst.sdt > 0) || soft.m_nodes.size() == 0) return false;
  const btCollisionObject* const object = opponent.getCollisionObject();
  const btScalar child(opponent.m_index);
  for (int i = 0; i < soft.m_rcontacts.size(); ++i) {
    const btSoftBody::RContact& known = soft.m_rcontacts[i];
    if (known.m_cti.m_colObj == object && known.m_c0[0].isZero() && known.m_c3 == child)
      return false;
  }
  btSoftBody::RContact mark;
  mark.m_cti.m_colObj = object;
  mark.m_cti.m_normal.setZero();
  mark.m_cti.m_offset = 0;
  mark.m_cti.m_bary.setZero();
  mark.m_node = &soft.m_nodes[0];
  mark.m_c0.setValue(0, 0, 0, 0, 0, 0, 0, 0, 0);  // Bullet multiplies its impulses by this
  mark.m_c1.setZero();
  mark.m_c2 = 0;
  mark.m_c3 = child;
  mark.m_c4 = 0;
  mark.t1.setZero();
  mark.t2.setZero();
  soft.m_rcontacts.push_back(mark);
  return true;
}

}  // namespace cloudcontact
