// A pair's law comes from the settings, the shapes, Bullet's own stiffness of a body, or from no
// one: then its spring follows from the bodies' masses, gravity, voxel and step.
#include "bullet/pair_law.h"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletSoftBody/btSoftBody.h>
#include <cloudcontact/bullet/cloud_shape.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bullet/convert.h"
#include "bullet/tissue_body.h"

namespace cloudcontact {

namespace {

constexpr const char* kTwoLaws =
    "two bodies state laws that cannot act in series (a viscoelastic law beside another, or one "
    "per area beside one per pair): state one law for the pair, CloudContactSettings::law";

// What one body states: a spring, or another law.
struct StatedLaw {
  const TissueTable* tissues = nullptr;
  std::optional<KelvinVoigt> spring;
  const Law* other = nullptr;
  bool byShape = false, byArea = false;  // of `spring`
};

StatedLaw statedBy(const btCollisionObjectWrapper& body) {
  const btCollisionShape* const shape = body.getCollisionShape();
  if (const CloudShape* const cloud = CloudShape::of(*shape)) {
    if (!cloud->tissues().empty()) return {&cloud->tissues(), {}, nullptr, false, false};
    if (const auto& own = cloud->law; own && !std::holds_alternative<Rigid>(*own)) {
      validate(*own);
      const bool byArea = std::holds_alternative<Foundation>(*own);
      if (!byArea && !std::holds_alternative<KelvinVoigt>(*own))
        return {nullptr, {}, &*own, false, false};
      return {nullptr, sharedSpring(*own), nullptr, true, byArea};
    }
  }
  const btCollisionObject* const object = body.getCollisionObject();
  if (shape->getShapeType() == SOFTBODY_SHAPE_PROXYTYPE)
    if (const auto* tissue = dynamic_cast<const TissueBody*>(object))
      return {&tissue->tissues, {}, nullptr, false, false};
  if (object->getCollisionFlags() & btCollisionObject::CF_HAS_CONTACT_STIFFNESS_DAMPING)
    return {nullptr, KelvinVoigt{object->getContactStiffness(), object->getContactDamping()}};
  return {};
}

// k and c by tissues. Their form is the settings': per pair, or per area with Foundation{}.
PairLaw tissueLaw(const StatedLaw& a, const StatedLaw& b, bool byArea) {
  if (a.other || b.other || (!byArea && (a.byArea || b.byArea))) throw std::runtime_error(kTwoLaws);
  PairLaw law;
  law.shared = byArea ? Law(Foundation{1, 0}) : Law(KelvinVoigt{1, 0});
  law.tissues[0] = a.tissues, law.tissues[1] = b.tissues;
  law.springs[0] = a.spring, law.springs[1] = b.spring;
  return law;
}

Law springLaw(const KelvinVoigt& spring, bool byArea) {
  if (byArea) return Foundation{spring.stiffness, spring.damping};
  return spring;
}

PairLaw fixedLaw(const Law& law) {
  if (std::holds_alternative<KelvinVoigt>(law) || std::holds_alternative<Foundation>(law))
    return {law, {}, nullptr, {}, {}};
  return {KelvinVoigt{1, 0}, {}, &law, {}, {}};
}

// [N] 0 for an object that contacts do not move, and for a multi-body's links, which do not know
// their gravity.
double weightOf(const btCollisionObject& object) {
  const auto* rigid = btRigidBody::upcast(&object);
  return rigid && rigid->getInvMass() > 0 ? rigid->getGravity().length() / rigid->getInvMass() : 0;
}

// The fraction of a voxel that the automatic spring takes for a voxel if both bodies move. Such
// bodies may bear others, and the sags of all joints of a stack add up.
constexpr double kJoint = 0.07;

AutomaticSpring springOf(const btCollisionObject& a, const btCollisionObject& b, double voxel,
                         double step, double bears) {
  const double inverseA = inverseMass(a), inverseB = inverseMass(b);
  return automaticSpring(1 / (inverseA + inverseB), std::max(weightOf(a), weightOf(b)), voxel, step,
                         inverseA > 0 && inverseB > 0 ? kJoint : 1, bears);
}

struct PairPoints {
  double whole = 0, depth = 0, closing = 0;
};

PairPoints gather(const PairSides& sides, const ContactResult& contact) {
  PairPoints sum;
  for (const ContactPoint& p : contact.points) {
    if (contact.patches[static_cast<std::size_t>(p.patch)].beside) continue;
    const Vec3 meeting = sides.motionA.at(p.position) - sides.motionB.at(p.position);
    sum.whole += p.stiffness;
    sum.depth += p.stiffness * std::max(0.0, p.depth);
    sum.closing += p.stiffness * meeting.dot(p.normal);
  }
  if (!(sum.whole > 0)) return {};
  sum.depth /= sum.whole;
  sum.closing /= sum.whole;
  return sum;
}

}  // namespace

const char* wrongMaterial(const btCollisionObject& object) {
  const auto isBad = [](btScalar value) { return !(value >= 0) || !std::isfinite(value); };
  if (isBad(object.getFriction()) || isBad(object.getRollingFriction()) ||
      isBad(object.getSpinningFriction()) || isBad(object.getRestitution()))
    return "a body's friction or restitution is NaN, infinite or negative, so it has no contacts: "
           "setFriction(), setRollingFriction(), setSpinningFriction(), setRestitution()";
  const bool states =
      object.getCollisionFlags() & btCollisionObject::CF_HAS_CONTACT_STIFFNESS_DAMPING;
  if (states && (isBad(object.getContactStiffness()) || isBad(object.getContactDamping())))
    return "a body's contact stiffness or damping is NaN, infinite or negative, so it has no "
           "contacts: setContactStiffnessAndDamping()";
  return nullptr;
}

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
    return {Rigid{}, {}, nullptr, {}, {}};
  if (world && !takesBodiesSprings(*world)) return fixedLaw(*world);
  const StatedLaw ofA = statedBy(a), ofB = statedBy(b);
  if (ofA.tissues || ofB.tissues) return tissueLaw(ofA, ofB, world.has_value());
  if (ofA.other || ofB.other) {
    if ((ofA.other && ofB.other) || ofA.spring || ofB.spring) throw std::runtime_error(kTwoLaws);
    return fixedLaw(ofA.other ? *ofA.other : *ofB.other);
  }
  if (!world && ofA.byShape && ofB.byShape && ofA.byArea != ofB.byArea)
    throw std::runtime_error(kTwoLaws);
  const bool byArea = world || ofA.byArea || ofB.byArea;
  if (const auto stated = inSeries(ofA.spring, ofB.spring))
    return {springLaw(*stated, byArea), {}, nullptr, {}, {}};
  return {springLaw({1, 0}, byArea),
          springOf(*a.getCollisionObject(), *b.getCollisionObject(), voxel, knownStep(step),
                   settings.bears),
          nullptr,
          {},
          {}};
}

PairMemory::Fingerprint PairMemory::fingerprintOf(
    const PairSides& sides, const std::vector<btPersistentManifold*>& manifolds) {
  Fingerprint print{};
  std::size_t n = 0;
  for (const btCollisionObjectWrapper* wrap : {sides.wrapA, sides.wrapB}) {
    const btTransform& place = wrap->getWorldTransform();
    for (int row = 0; row < 3; ++row)
      for (int i = 0; i < 3; ++i) print[n++] = place.getBasis()[row][i];
    for (int i = 0; i < 3; ++i) print[n++] = place.getOrigin()[i];
  }
  for (const Motion* motion : {&sides.motionA, &sides.motionB})
    for (const Vec3* v : {&motion->linear, &motion->angular})
      for (int i = 0; i < 3; ++i) print[n++] = static_cast<btScalar>((*v)[i]);
  for (const btPersistentManifold* manifold : manifolds)
    for (int i = 0; i < manifold->getNumContacts(); ++i)
      print[n] += manifold->getContactPoint(i).m_appliedImpulse;
  return print;
}

KelvinVoigt PairMemory::row(const Law& law, const PairSides& sides, const ContactResult& contact,
                            const std::vector<btPersistentManifold*>& manifolds, double step) {
  const PairPoints points = gather(sides, contact);
  if (step_ == 0)
    law_ = lawAdvance(law, {}, points.depth, step);
  else if (fingerprintOf(sides, manifolds) != fingerprint_)
    law_ = lawAdvance(law, law_, points.depth, step_);
  step_ = step;
  const LawTangent line = lawTangent(law, law_, points.closing, step);
  if (!(points.whole > 0)) return {};
  // For points that do not touch yet only the sum, grip, matters.
  const double k = points.depth > 0 ? line.force / points.depth : line.grip / step;
  return {k / points.whole, (line.grip - step * k) / points.whole};
}

void PairMemory::remember(const PairSides& sides,
                          const std::vector<btPersistentManifold*>& manifolds) {
  fingerprint_ = fingerprintOf(sides, manifolds);
}

}  // namespace cloudcontact
