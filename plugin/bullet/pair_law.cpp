// Materials of a pair: the settings', the shapes', Bullet's own per body, or none's: a spring that
// follows from the bodies' masses, gravity, voxel and step.
#include "bullet/pair_law.h"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletSoftBody/btSoftBody.h>
#include <cloudcontact/bullet/cloud_shape.h>

#include <algorithm>
#include <stdexcept>

namespace cloudcontact {

namespace {

constexpr const char* kTwoLaws =
    "a shape with a viscoelastic law of its own meets one with a law or material: state one law "
    "for the pair, CloudContactSettings::viscoelastic";

const ViscoelasticLaw* ownLaw(const btCollisionObjectWrapper& body) {
  const btCollisionShape* const shape = body.getCollisionShape();
  if (shape->getShapeType() != HFFLUID_SHAPE_PROXYTYPE) return nullptr;
  const auto& own = static_cast<const CloudShape*>(shape)->viscoelastic;
  return own ? &*own : nullptr;
}

std::optional<Material> materialOf(const btCollisionObjectWrapper& body) {
  const btCollisionShape* const shape = body.getCollisionShape();
  if (shape->getShapeType() == HFFLUID_SHAPE_PROXYTYPE)
    if (const auto& own = static_cast<const CloudShape*>(shape)->material) return own;
  const btCollisionObject* const object = body.getCollisionObject();
  if (object->getCollisionFlags() & btCollisionObject::CF_HAS_CONTACT_STIFFNESS_DAMPING)
    return Material{object->getContactStiffness(), object->getContactDamping()};
  return std::nullopt;
}

// [N] 0 for what no contact moves, and for a multi-body's links, which do not know what pulls them.
double weightOf(const btCollisionObject& object) {
  const auto* rigid = btRigidBody::upcast(&object);
  return rigid && rigid->getInvMass() > 0 ? rigid->getGravity().length() / rigid->getInvMass() : 0;
}

// The part of a voxel that the automatic spring takes for one where both bodies move. They may bear
// others, and then the sags of all joints add up: ten boxes stand 0.9 voxel lower with 0.25, 1.0
// with 0.3, 2.8 with 1. What stands still does so for one of them alone.
constexpr double kJoint = 0.25;

AutomaticSpring springOf(const btCollisionObject& a, const btCollisionObject& b, double voxel,
                         double step, double bears) {
  const double inverseA = inverseMass(a), inverseB = inverseMass(b);
  return automaticSpring(1 / (inverseA + inverseB), std::max(weightOf(a), weightOf(b)), voxel, step,
                         inverseA > 0 && inverseB > 0 ? kJoint : 1, bears);
}

}  // namespace

double inverseMass(const btCollisionObject& object) {
  if (const auto* rigid = btRigidBody::upcast(&object)) return rigid->getInvMass();
  if (const auto* collider = btMultiBodyLinkCollider::upcast(&object)) {
    const btMultiBody& body = *collider->m_multiBody;
    if (collider->m_link < 0 && body.hasFixedBase()) return 0;
    const double mass =
        collider->m_link < 0 ? body.getBaseMass() : body.getLink(collider->m_link).m_mass;
    return mass > 0 ? 1 / mass : 0;
  }
  if (const auto* soft = btSoftBody::upcast(&object)) {
    double mass = 0;
    for (int i = 0; i < soft->m_nodes.size(); ++i)
      if (soft->m_nodes[i].m_im > 0) mass += 1 / soft->m_nodes[i].m_im;
    return mass > 0 ? 1 / mass : 0;
  }
  return 0;
}

PairLaw lawOf(const CloudContactSettings& settings, const btCollisionObjectWrapper& a,
              const btCollisionObjectWrapper& b, double voxel, double step) {
  const double inverse =
      inverseMass(*a.getCollisionObject()) + inverseMass(*b.getCollisionObject());
  if (settings.law == LawForm::Rigid || !(inverse > 0)) return {LawForm::Rigid, {}, {}, nullptr};
  if (settings.viscoelastic) return {settings.law, {1, 0}, {}, &*settings.viscoelastic};
  if (settings.pair) return {settings.law, *settings.pair, {}, nullptr};
  const ViscoelasticLaw *lawA = ownLaw(a), *lawB = ownLaw(b);
  const auto materialA = materialOf(a), materialB = materialOf(b);
  if (lawA || lawB) {
    if ((lawA && (lawB || materialB)) || (lawB && materialA)) throw std::runtime_error(kTwoLaws);
    return {LawForm::Paper, {1, 0}, {}, lawA ? lawA : lawB};
  }
  if (const auto stated = inSeries(materialA, materialB))
    return {settings.law, *stated, {}, nullptr};
  return {settings.law,
          {1, 0},
          springOf(*a.getCollisionObject(), *b.getCollisionObject(), voxel, knownStep(step),
                   settings.bears),
          nullptr};
}

}  // namespace cloudcontact
