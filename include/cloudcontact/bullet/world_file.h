// Worlds with clouds in Bullet's own `.bullet` files: saving. CloudImporter (world_importer.h)
// loads them.
//
// btDynamicsWorld::serialize() with Bullet's serializer keeps clouds too, with their fields; what a
// CloudSerializer adds are the contacts, so that a loaded world goes on as the saved one, to the
// bit, and a checksum.
#pragma once

#include <LinearMath/btSerializer.h>
#include <cloudcontact/bullet/cloud_contact.h>

#include <filesystem>
#include <string>

class btDynamicsWorld;

namespace cloudcontact {

// For what needs the serializer itself, such as names of bodies (registerNameForPointer()).
class CloudSerializer : public btDefaultSerializer {
 public:
  // Both must outlive it.
  CloudSerializer(btDynamicsWorld& world, const CloudContact& contact);

  // Bullet calls it at the beginning of btDynamicsWorld::serialize().
  void startSerialization() override;
  // Writes what was serialized: whole, or not at all. Throws std::runtime_error that names the file
  // where it cannot be written, and where a cloud cannot be kept: its law is a function, an area of
  // the paper's method is a cloud, or edges of a cut are still to be searched
  // (CuttableBody::settle()).
  void save(const std::filesystem::path& file) const;

 private:
  btDynamicsWorld& world_;
  const CloudContact& contact_;
};

// Bodies, shapes, joints, contacts and settings of the world. What Bullet's files do not hold is
// not kept: soft and multi-bodies, ghosts, own shapes, motion states, user pointers, and, in
// double, what they hold in float: the sizes of Bullet's shapes and the places of a compound's
// children. Throws as CloudSerializer::save().
void saveWorld(btDynamicsWorld& world, const CloudContact& contact,
               const std::filesystem::path& file);

}  // namespace cloudcontact
