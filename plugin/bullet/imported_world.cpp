// From what Bullet's loader has parsed to shapes and bodies.
#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletDynamics/ConstraintSolver/btContactSolverInfo.h>
#include <cloudcontact/bullet/imported_world.h>

#include <cmath>
#include <cstddef>
#include <sstream>

#include "base/byte_archive.h"
#include "bullet/contact_record.h"
#include "bullet/shape_record.h"
#include "bullet/world_bytes.h"
#include "field/field_bytes.h"
#include "voxels/cloud_bytes.h"

namespace cloudcontact {

namespace {

// checkWorldBytes() has seen that records end within the file.
constexpr std::size_t kAny = std::size_t(1) << 40;

// Bullet hands on the bytes of a cloud's records by pointers to data of other types.
const char* bytesAt(const void* data) {
  return static_cast<const char*>(data);
}

std::shared_ptr<const SurfaceField> fieldAt(const char* bytes) {
  if (!bytes || std::memcmp(bytes, kFieldMagic, sizeof kFieldMagic) != 0)
    throw std::runtime_error("a cloud has no field");
  std::uint64_t length = 0;
  std::memcpy(&length, bytes + kFieldLengthAt, sizeof length);
  length = inFileOrder(length);
  std::istringstream in(std::string(bytes, length));
  return readField(in, length, "its field");
}

// A vector or transform of Bullet's from its data in float or in double.
template <typename Value, typename Data>
Value valueOf(const Data& data) {
  Value value;
  if constexpr (std::is_same_v<Data, btVector3FloatData> ||
                std::is_same_v<Data, btTransformFloatData>)
    value.deSerializeFloat(data);
  else
    value.deSerializeDouble(data);
  return value;
}
template <typename Data>
btVector3 vectorOf(const Data& data) {
  return valueOf<btVector3>(data);
}

// A mass with exactly this inverse, as Bullet keeps the inverse alone.
btScalar massOf(btScalar inverse) {
  if (!(inverse > 0)) return 0;
  const btScalar mass = 1 / inverse;
  for (const btScalar towards : {-BT_LARGE_FLOAT, BT_LARGE_FLOAT}) {
    btScalar near = mass;
    for (int i = 0; i < 4; ++i, near = std::nextafter(near, towards))
      if (1 / near == inverse) return near;
  }
  return mass;
}

template <typename Data>
void restoreObject(btCollisionObject& object, const Data& data) {
  object.setInterpolationWorldTransform(valueOf<btTransform>(data.m_interpolationWorldTransform));
  object.setInterpolationLinearVelocity(vectorOf(data.m_interpolationLinearVelocity));
  object.setInterpolationAngularVelocity(vectorOf(data.m_interpolationAngularVelocity));
  object.setAnisotropicFriction(vectorOf(data.m_anisotropicFriction),
                                data.m_hasAnisotropicFriction);
  object.setContactProcessingThreshold(btScalar(data.m_contactProcessingThreshold));
  object.setFriction(btScalar(data.m_friction));
  object.setRollingFriction(btScalar(data.m_rollingFriction));
  object.setRestitution(btScalar(data.m_restitution));
  object.setContactStiffnessAndDamping(btScalar(data.m_contactStiffness),
                                       btScalar(data.m_contactDamping));
  object.setCollisionFlags(data.m_collisionFlags);
  object.forceActivationState(data.m_activationState1);
  object.setDeactivationTime(btScalar(data.m_deactivationTime));
  object.setHitFraction(btScalar(data.m_hitFraction));
  object.setCcdSweptSphereRadius(btScalar(data.m_ccdSweptSphereRadius));
  object.setCcdMotionThreshold(btScalar(data.m_ccdMotionThreshold));
}

template <typename Data>
void restore(btRigidBody& body, const Data& data) {
  const auto inverse = btScalar(data.m_inverseMass);
  const btVector3 inertia = vectorOf(data.m_invInertiaLocal);
  body.setMassProps(massOf(inverse), btVector3(0, 0, 0));
  body.setInvInertiaDiagLocal(inertia);
  body.setWorldTransform(valueOf<btTransform>(data.m_collisionObjectData.m_worldTransform));
  body.updateInertiaTensor();
  restoreObject(body, data.m_collisionObjectData);
  body.setLinearVelocity(vectorOf(data.m_linearVelocity));
  body.setAngularVelocity(vectorOf(data.m_angularVelocity));
  body.setLinearFactor(btVector3(1, 1, 1));
  body.setAngularFactor(btVector3(1, 1, 1));
  body.clearForces();
  body.applyCentralForce(vectorOf(data.m_totalForce));
  body.applyTorque(vectorOf(data.m_totalTorque));
  body.setLinearFactor(vectorOf(data.m_linearFactor));
  body.setAngularFactor(vectorOf(data.m_angularFactor));
  body.setDamping(btScalar(data.m_linearDamping), btScalar(data.m_angularDamping));
  body.setSleepingThresholds(btScalar(data.m_linearSleepingThreshold),
                             btScalar(data.m_angularSleepingThreshold));
}

}  // namespace

std::vector<char> readWorldFile(const std::filesystem::path& file) {
  std::ifstream in = openFile(file, "a world file");
  std::vector<char> bytes(std::filesystem::file_size(file));
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!in) refuseFile(file, "cannot be read to its end");
  checkWorldBytes(bytes, file);
  return bytes;
}

std::unique_ptr<CloudShape> ImportedWorld::shape(const btCollisionShapeData& data) {
  static_assert(offsetof(btTriangleMeshShapeData, m_collisionShapeData) == 0);
  const auto& mesh = reinterpret_cast<const btTriangleMeshShapeData&>(data);
  const auto* const record = bytesAt(mesh.m_meshInterface.m_meshPartsPtr);
  if (!record) throw std::runtime_error("a cloud has no record; save it with this library");
  const ShapeRecord kept = ShapeRecord::from(opened(kShapeKind, record, kAny));
  if (!kept.refused.empty()) throw std::runtime_error("a cloud was not saved: " + kept.refused);
  auto& field = fields_[mesh.m_quantizedFloatBvh];
  if (!field) field = fieldAt(bytesAt(mesh.m_quantizedFloatBvh));
  if (mesh.m_quantizedDoubleBvh) contacts_ = bytesAt(mesh.m_quantizedDoubleBvh);
  return kept.make(field);
}

void ImportedWorld::restoreContacts(btDynamicsWorld& world, CloudContact& contact,
                                    const std::vector<btRigidBody*>& bodies) const {
  if (contacts_)
    cloudcontact::restoreContacts(world, ContactRecords::narrowPhaseOf(contact), bodies,
                                  opened(kContactsKind, contacts_, kAny));
}

void takeSaved(const btContactSolverInfo& saved, btContactSolverInfo& info) {
  info.m_tau = saved.m_tau;
  info.m_damping = saved.m_damping;
  info.m_friction = saved.m_friction;
  info.m_timeStep = saved.m_timeStep;
  info.m_restitution = saved.m_restitution;
  info.m_maxErrorReduction = saved.m_maxErrorReduction;
  info.m_sor = saved.m_sor;
  info.m_erp = saved.m_erp;
  info.m_erp2 = saved.m_erp2;
  info.m_globalCfm = saved.m_globalCfm;
  info.m_splitImpulsePenetrationThreshold = saved.m_splitImpulsePenetrationThreshold;
  info.m_splitImpulseTurnErp = saved.m_splitImpulseTurnErp;
  info.m_linearSlop = saved.m_linearSlop;
  info.m_warmstartingFactor = saved.m_warmstartingFactor;
  info.m_maxGyroscopicForce = saved.m_maxGyroscopicForce;
  info.m_singleAxisRollingFrictionThreshold = saved.m_singleAxisRollingFrictionThreshold;
  info.m_numIterations = saved.m_numIterations;
  info.m_solverMode = saved.m_solverMode;
  info.m_restingContactRestitutionThreshold = saved.m_restingContactRestitutionThreshold;
  info.m_minimumSolverBatchSize = saved.m_minimumSolverBatchSize;
  info.m_splitImpulse = saved.m_splitImpulse;
}

void restoreBody(btRigidBody& body, const btRigidBodyFloatData& data) {
  restore(body, data);
}
void restoreBody(btRigidBody& body, const btRigidBodyDoubleData& data) {
  restore(body, data);
}
void restoreGravity(btRigidBody& body, const btRigidBodyFloatData& data) {
  body.setGravity(vectorOf(data.m_gravity_acceleration));
}
void restoreGravity(btRigidBody& body, const btRigidBodyDoubleData& data) {
  body.setGravity(vectorOf(data.m_gravity_acceleration));
}

}  // namespace cloudcontact
