// CloudImporter: loads `.bullet` files with clouds. Link Bullet's libraries BulletWorldImporter and
// BulletFileLoader (of Debian's libbullet-extras-dev), which CloudContact itself does not need.
#pragma once

#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>
#include <BulletDynamics/Dynamics/btDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletFileLoader/btBulletFile.h>
#include <BulletWorldImporter/btBulletWorldImporter.h>
#include <cloudcontact/bullet/imported_world.h>

#include <cstddef>
#include <filesystem>
#include <vector>

namespace cloudcontact {

// In place of btBulletWorldImporter. Bodies get all that the file says of them, also velocities,
// inertia, flags and groups, which Bullet's leaves out; joints of one body stay where they were. As
// Bullet's importer, it owns all that it has loaded until deleteAllData() takes that out of the
// world and deletes it; the destructor does not.
class CloudImporter : public btBulletWorldImporter {
 public:
  // `contact` is attached to the world's dispatcher; null: contacts begin as between bodies that
  // have just met. The world is empty: CloudSerializer's contacts are those of the whole world.
  explicit CloudImporter(btDynamicsWorld* world, CloudContact* contact = nullptr)
      : btBulletWorldImporter(world), contact_(contact) {}

  // Throws std::runtime_error, naming the file, where it is missing, is no file of Bullet, is cut
  // short or damaged, or holds a cloud that was not kept. Returns true.
  bool loadFile(const std::filesystem::path& file) {
    std::vector<char> bytes = readWorldFile(file);
    return load(bytes.data(), static_cast<int>(bytes.size()), file);
  }
  bool loadFileFromMemory(char* bytes, int count) {
    checkWorldBytes({bytes, std::size_t(count)}, "memory");
    return load(bytes, count, "memory");
  }

  bool convertAllObjects(bParse::btBulletFile* file) override {
    imported_ = ImportedWorld();
    bodies_.clear();
    convertWorld(*file);
    for (int i = 0; i < file->m_collisionShapes.size(); ++i)
      shapeOf(&dataAt<btCollisionShapeData>(file->m_collisionShapes[i]));
    const bool isDouble = file->getFlags() & bParse::FD_DOUBLE_PRECISION;
    for (int i = 0; i < file->m_rigidBodies.size(); ++i)
      isDouble ? convertBody(dataAt<btRigidBodyDoubleData>(file->m_rigidBodies[i]))
               : convertBody(dataAt<btRigidBodyFloatData>(file->m_rigidBodies[i]));
    for (int i = 0; i < file->m_collisionObjects.size(); ++i)
      isDouble ? convertObject(dataAt<btCollisionObjectDoubleData>(file->m_collisionObjects[i]))
               : convertObject(dataAt<btCollisionObjectFloatData>(file->m_collisionObjects[i]));
    for (int i = 0; i < file->m_constraints.size(); ++i)
      convertJoint(file->m_constraints[i], isDouble, file->getVersion());
    if (contact_ && m_dynamicsWorld)
      imported_.restoreContacts(*m_dynamicsWorld, *contact_, bodies_);
    return true;
  }

  // Settings that the file does not hold stay as they are.
  void setDynamicsWorldInfo(const btVector3& gravity, const btContactSolverInfo& info) override {
    if (!m_dynamicsWorld) return;
    m_dynamicsWorld->setGravity(gravity);
    takeSaved(info, m_dynamicsWorld->getSolverInfo());
  }

 private:
  // What a file's flags, or a shape's type, say that the data are. They begin with their base's.
  template <typename Data>
  static Data& dataAt(void* data) {
    return *static_cast<Data*>(data);
  }
  static_assert(offsetof(btCompoundShapeData, m_collisionShapeData) == 0);

  bool load(char* bytes, int count, const std::filesystem::path& file) {
    bParse::btBulletFile parsed(bytes, count);
    return imported_.naming(file,
                            [&] { return btBulletWorldImporter::loadFileFromMemory(&parsed); });
  }

  // Trees of meshes and the world's settings, by Bullet, which first forgets all shapes and bodies.
  void convertWorld(bParse::btBulletFile& file) {
    const auto shapes = file.m_collisionShapes, bodies = file.m_rigidBodies,
               objects = file.m_collisionObjects, constraints = file.m_constraints;
    for (auto* list : {&file.m_collisionShapes, &file.m_rigidBodies, &file.m_collisionObjects,
                       &file.m_constraints})
      list->clear();
    btBulletWorldImporter::convertAllObjects(&file);
    file.m_collisionShapes = shapes;
    file.m_rigidBodies = bodies;
    file.m_collisionObjects = objects;
    file.m_constraints = constraints;
  }

  btCollisionShape* shapeOf(btCollisionShapeData* data) {
    if (!data) return nullptr;
    if (btCollisionShape** const known = m_shapeMap.find(data)) return *known;
    btCollisionShape* shape = nullptr;
    if (data->m_shapeType == CloudShape::kCloudType) {
      shape = imported_.shape(*data).release();
      m_allocatedCollisionShapes.push_back(shape);
    } else if (data->m_shapeType == COMPOUND_SHAPE_PROXYTYPE) {
      shape = compoundOf(dataAt<btCompoundShapeData>(data));
    } else {
      shape = convertCollisionShape(data);
    }
    if (!shape) return nullptr;
    m_shapeMap.insert(data, shape);
    if (data->m_name) {
      char* const name = duplicateName(data->m_name);
      m_objectNameMap.insert(shape, name);
      m_nameShapeMap.insert(name, shape);
    }
    return shape;
  }

  btCollisionShape* compoundOf(const btCompoundShapeData& data) {
    btCompoundShape* const compound = createCompoundShape();
    for (int i = 0; i < data.m_numChildShapes; ++i) {
      btTransform place;
      place.deSerializeFloat(data.m_childShapePtr[i].m_transform);
      if (btCollisionShape* const child = shapeOf(data.m_childShapePtr[i].m_childShape))
        compound->addChildShape(place, child);
    }
    compound->setMargin(btScalar(data.m_collisionMargin));
    return compound;
  }

  template <typename Data>
  void convertBody(Data& data) {
    const auto& object = data.m_collisionObjectData;
    btCollisionShape* const shape =
        shapeOf(static_cast<btCollisionShapeData*>(object.m_collisionShape));
    if (!shape) return;
    const bool moves = data.m_inverseMass != 0;
    btRigidBody* const body = createRigidBody(moves, btScalar(moves ? 1 / data.m_inverseMass : 0),
                                              placeOf(object), shape, object.m_name);
    if (m_dynamicsWorld) m_dynamicsWorld->removeRigidBody(body);
    restoreBody(*body, data);
    if (m_dynamicsWorld)
      m_dynamicsWorld->addRigidBody(body, object.m_collisionFilterGroup,
                                    object.m_collisionFilterMask);
    restoreGravity(*body, data);
    m_bodyMap.insert(&data, body);
    bodies_.push_back(body);
  }

  template <typename Data>
  void convertObject(Data& data) {
    btCollisionShape* const shape =
        shapeOf(static_cast<btCollisionShapeData*>(data.m_collisionShape));
    if (!shape) return;
    btCollisionObject* const object = createCollisionObject(placeOf(data), shape, data.m_name);
    object->setFriction(btScalar(data.m_friction));
    object->setRestitution(btScalar(data.m_restitution));
    m_bodyMap.insert(&data, object);
  }

  // A body that is not in the file is the world: its frame says where the joint is.
  btRigidBody* bodyOf(const void* data) {
    btCollisionObject** const found = m_bodyMap.find(data);
    btRigidBody* const body = found ? btRigidBody::upcast(*found) : nullptr;
    return body ? body : &getFixedBody();
  }
  void convertJoint(void* joint, bool isDouble, int version) {
    auto* const data = static_cast<btTypedConstraintData2*>(joint);
    btRigidBody *const a = bodyOf(data->m_rbA), *const b = bodyOf(data->m_rbB);
    if (a == b) return;
    if (isDouble)
      convertConstraintDouble(static_cast<btTypedConstraintDoubleData*>(joint), a, b, version);
    else
      convertConstraintFloat(static_cast<btTypedConstraintFloatData*>(joint), a, b, version);
  }

  CloudContact* contact_;
  ImportedWorld imported_;
  std::vector<btRigidBody*> bodies_;  // of the file, by rank
};

}  // namespace cloudcontact
