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
    "two bodies state laws that cannot act in series (a viscoelastic law beside another, or one "
    "per area beside one per pair): state one law for the pair, CloudContactSettings::law";

// What one body states: a spring, or another law.
struct StatedLaw {
  std::optional<KelvinVoigt> spring;
  const Law* other = nullptr;
  bool byShape = false, byArea = false;  // of `spring`
};

StatedLaw statedBy(const btCollisionObjectWrapper& body) {
  const btCollisionShape* const shape = body.getCollisionShape();
  if (shape->getShapeType() == HFFLUID_SHAPE_PROXYTYPE)
    if (const auto& own = static_cast<const CloudShape*>(shape)->law;
        own && !std::holds_alternative<Rigid>(*own)) {
      const bool byArea = std::holds_alternative<Foundation>(*own);
      if (!byArea && !std::holds_alternative<KelvinVoigt>(*own)) return {{}, &*own, false, false};
      return {sharedSpring(*own), nullptr, true, byArea};
    }
  const btCollisionObject* const object = body.getCollisionObject();
  if (object->getCollisionFlags() & btCollisionObject::CF_HAS_CONTACT_STIFFNESS_DAMPING)
    return {KelvinVoigt{object->getContactStiffness(), object->getContactDamping()}};
  return {};
}

Law springLaw(const KelvinVoigt& spring, bool byArea) {
  if (byArea) return Foundation{spring.stiffness, spring.damping};
  return spring;
}

PairLaw fixedLaw(const Law& law) {
  if (std::holds_alternative<KelvinVoigt>(law) || std::holds_alternative<Foundation>(law))
    return {law, {}, nullptr};
  return {KelvinVoigt{1, 0}, {}, &law};
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

bool takesBodiesSprings(const Law& law) {
  const auto* area = std::get_if<Foundation>(&law);
  return area && area->stiffness == 0 && area->damping == 0;
}

PairLaw lawOf(const CloudContactSettings& settings, const btCollisionObjectWrapper& a,
              const btCollisionObjectWrapper& b, double voxel, double step) {
  const double inverse =
      inverseMass(*a.getCollisionObject()) + inverseMass(*b.getCollisionObject());
  const std::optional<Law>& world = settings.law;
  if ((world && std::holds_alternative<Rigid>(*world)) || !(inverse > 0))
    return {Rigid{}, {}, nullptr};
  if (world && !takesBodiesSprings(*world)) return fixedLaw(*world);
  const StatedLaw ofA = statedBy(a), ofB = statedBy(b);
  if (ofA.other || ofB.other) {
    if ((ofA.other && ofB.other) || ofA.spring || ofB.spring) throw std::runtime_error(kTwoLaws);
    return fixedLaw(ofA.other ? *ofA.other : *ofB.other);
  }
  if (!world && ofA.byShape && ofB.byShape && ofA.byArea != ofB.byArea)
    throw std::runtime_error(kTwoLaws);
  const bool byArea = world || ofA.byArea || ofB.byArea;
  if (const auto stated = inSeries(ofA.spring, ofB.spring))
    return {springLaw(*stated, byArea), {}, nullptr};
  return {springLaw({1, 0}, byArea),
          springOf(*a.getCollisionObject(), *b.getCollisionObject(), voxel, knownStep(step),
                   settings.bears),
          nullptr};
}

}  // namespace cloudcontact
