// What CloudImporter (world_importer.h) needs of the library, which does not link Bullet's
// importer.
#pragma once

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <cloudcontact/base/span.h>
#include <cloudcontact/bullet/cloud_contact.h>
#include <cloudcontact/bullet/cloud_shape.h>

#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>
#include <vector>

class btDynamicsWorld;
struct btContactSolverInfo;

namespace cloudcontact {

// Throws std::runtime_error, naming the file, where it is missing or as checkWorldBytes().
std::vector<char> readWorldFile(const std::filesystem::path& file);
// Throws std::runtime_error, naming the file, where the bytes are no file of Bullet, are cut short,
// or are not what CloudSerializer wrote. Bullet's own loader reads beyond the end of such files.
void checkWorldBytes(Span<const char> bytes, const std::filesystem::path& file);

class ImportedWorld {
 public:
  // Throws std::runtime_error where the cloud was not kept or is damaged.
  std::unique_ptr<CloudShape> shape(const btCollisionShapeData& data);
  // The contacts that the file holds, if any. `bodies`: all of the file, in its order.
  void restoreContacts(btDynamicsWorld& world, CloudContact& contact,
                       const std::vector<btRigidBody*>& bodies) const;
  // Puts the file's name before what `load` throws.
  template <typename Load>
  static bool naming(const std::filesystem::path& file, Load&& load) {
    try {
      if (load()) return true;
    } catch (const std::runtime_error& why) {
      throw std::runtime_error(file.string() + ": " + why.what());
    }
    throw std::runtime_error(file.string() + ": Bullet cannot read it");
  }

 private:
  std::map<const void*, std::shared_ptr<const SurfaceField>> fields_;  // by place in the file
  const char* contacts_ = nullptr;
};

// Copies what a file keeps of solver settings.
void takeSaved(const btContactSolverInfo& saved, btContactSolverInfo& info);

// Where the file has an object, in float and in double.
inline btTransform placeOf(const btCollisionObjectFloatData& data) {
  btTransform place;
  place.deSerializeFloat(data.m_worldTransform);
  return place;
}
// The same.
inline btTransform placeOf(const btCollisionObjectDoubleData& data) {
  btTransform place;
  place.deSerializeDouble(data.m_worldTransform);
  return place;
}

// All that the file says of a body. Gravity is set after the body is added to its world, which sets
// it too.
void restoreBody(btRigidBody& body, const btRigidBodyFloatData& data);
// The same.
void restoreBody(btRigidBody& body, const btRigidBodyDoubleData& data);
// That of the file.
void restoreGravity(btRigidBody& body, const btRigidBodyFloatData& data);
// The same.
void restoreGravity(btRigidBody& body, const btRigidBodyDoubleData& data);

}  // namespace cloudcontact
