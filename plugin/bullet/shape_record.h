// ShapeRecord: what a CloudShape has beside its field, as bytes in Bullet's files.
//
// Bullet's files know Bullet's structs alone, and arrays of chars. A cloud is a
// btTriangleMeshShapeData of type CloudShape::kCloudType: where a mesh points to its parts it
// points to this record, where a mesh points to its tree of floats to its field, which shapes
// share, and where a mesh points to its tree of doubles to the contacts of the world
// (contact_record.h), if they are kept.
#pragma once

#include <cloudcontact/bullet/cloud_shape.h>

#include <memory>
#include <span>
#include <string>

class btSerializer;
struct btCollisionShapeData;

namespace cloudcontact {

// A record: its kind, its length, a version, bytes and their checksum.
constexpr std::size_t kKindLength = 8;
constexpr const char* kShapeKind = "CLDSHAPE";
constexpr const char* kContactsKind = "CLDPAIRS";
std::string sealed(const char* kind, const std::string& bytes);
// The bytes of a record of this kind. Throws std::runtime_error for another kind or version, and
// where it is damaged. `room`: the most that it may take.
std::span<const char> opened(const char* kind, const char* record, std::size_t room);

// Writes bytes as a chunk that is found by `key`, once. Returns what structs in the file point to.
void* writeChunk(btSerializer& serializer, const void* key, const std::string& bytes);
// Where the record of the world's contacts is found.
void* contactsKey();
// Why Bullet's serializer does not keep the shape; empty if it does.
std::string whyNotKept(const CloudShape& shape);

struct ShapeRecord {
  std::optional<Law> law;
  TissueTable tissues;
  double tolerance = 0;
  bool exact = false;
  bool usesPaper = false;
  PaperSettings paper;
  std::optional<PlacedSolid> solid;  // CloudShape::setSolid(), with its voxel
  double solidVoxel = 0;
  double margin = 0, fieldScaling = 1;
  Vec3 scaling = Vec3::Ones();
  std::int32_t userIndex = -1;
  std::string refused;  // why the shape is not kept; empty if it is

  static ShapeRecord of(const CloudShape& shape);
  // Throws std::runtime_error for a law or an area that is no data: a function, a cloud.
  std::string bytes() const;
  static ShapeRecord from(std::span<const char> bytes);
  std::unique_ptr<CloudShape> make(std::shared_ptr<const SurfaceField> field) const;
};

}  // namespace cloudcontact
