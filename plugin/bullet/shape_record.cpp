// Records of shapes, and how CloudShape is written.
#include "bullet/shape_record.h"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <LinearMath/btSerializer.h>

#include <sstream>
#include <stdexcept>

#include "base/byte_archive.h"
#include "base/hash.h"
#include "bullet/convert.h"
#include "field/field_bytes.h"

namespace cloudcontact {

namespace {

constexpr std::uint32_t kVersion = 9;
constexpr const char* kNoData =
    "a law that is a function, or an area of the paper's method that is a cloud, cannot be saved: "
    "set it again after loading";

// The alternative that an archive says, or that `value` holds.
template <typename Archive, typename... Kinds, typename Visit>
void variantIn(Archive& archive, std::variant<Kinds...>& value, Visit&& visit) {
  auto kind = static_cast<std::uint8_t>(value.index());
  archive(kind);
  if constexpr (Archive::kReads) {
    if (kind >= sizeof...(Kinds)) throw std::runtime_error("a record says an unknown kind");
    std::uint8_t at = 0;
    ((at++ == kind ? (void)value.template emplace<Kinds>() : (void)0), ...);
  }
  std::visit(visit, value);
}

template <typename Archive>
struct LawVisitor {
  Archive& archive;
  void operator()(KelvinVoigt& x) { archive(x.stiffness, x.damping); }
  void operator()(Foundation& x) { archive(x.stiffness, x.damping); }
  void operator()(Rigid&) {}
  void operator()(Maxwell& x) { archive(x.stiffness, x.damping); }
  void operator()(StandardLinearSolid& x) {
    archive(x.stiffness, x.branchStiffness, x.branchDamping);
  }
  void operator()(UserLaw&) { throw std::runtime_error(kNoData); }
  void operator()(TableLaw& x) {
    listIn(archive, x.depthForce,
           [](Archive& a, std::array<double, 2>& row) { a(row[0], row[1]); });
    archive(x.damping);
  }
};

template <typename Archive>
struct SolidVisitor {
  Archive& archive;
  void operator()(HalfSpace& x) { archive(x.normal, x.offset); }
  void operator()(Sphere& x) { archive(x.radius); }
  void operator()(Box& x) { archive(x.halfExtents); }
  void operator()(Ellipsoid& x) { archive(x.semiAxes); }
  void operator()(Capsule& x) { archive(x.radius, x.halfHeight); }
  void operator()(Cylinder& x) { archive(x.radius, x.halfHeight); }
  void operator()(Cone& x) { archive(x.radius, x.halfHeight, x.margin); }
  void operator()(Hull& x) {
    listIn(archive, x.planes, [](Archive& a, HalfSpace& plane) { a(plane.normal, plane.offset); });
    listIn(archive, x.corners, [](Archive& a, Vec3& corner) { a(corner); });
    listIn(archive, x.edges,
           [](Archive& a, std::pair<int, int>& edge) { a(edge.first, edge.second); });
    archive(x.margin);
  }
  void operator()(CloudSolid&) { throw std::runtime_error(kNoData); }
  void operator()(SurfaceSolid&) { throw std::runtime_error(kNoData); }
};

template <typename Archive>
void areaIn(Archive& archive, PlacedSolid& area) {
  variantIn(archive, area.solid, SolidVisitor<Archive>{archive});
  archive(area.place.orientation.coeffs().x(), area.place.orientation.coeffs().y(),
          area.place.orientation.coeffs().z(), area.place.orientation.coeffs().w(),
          area.place.position);
}

template <typename Archive>
void paperIn(Archive& archive, PaperSettings& paper) {
  optionalIn(archive, paper.window, [](Archive& a, WindowSettings& window) {
    areaIn(a, window.area);
    a(window.weight, window.representative);
  });
  optionalIn(archive, paper.area, areaIn<Archive>);
  archive(paper.membership, paper.hardness, paper.ability);
  listIn(archive, paper.parts, [](Archive& a, CuttingPart& part) {
    areaIn(a, part.area);
    a(part.ability);
  });
}

template <typename Archive>
void shapeIn(Archive& archive, ShapeRecord& record) {
  archive(record.refused);
  optionalIn(archive, record.law,
             [](Archive& a, Law& law) { variantIn(a, law, LawVisitor<Archive>{a}); });
  listIn(archive, record.tissues, [](Archive& a, Tissue& t) {
    a(t.name, t.stiffness, t.damping, t.hardness, t.density, t.elasticity);
  });
  archive(record.tolerance, record.exact, record.usesPaper);
  paperIn(archive, record.paper);
  optionalIn(archive, record.solid, areaIn<Archive>);
  archive(record.solidVoxel);
  archive(record.margin, record.fieldScaling, record.scaling, record.userIndex);
}

std::uint64_t hashOf(std::span<const char> bytes) {
  WordHash hash;
  hash.add(bytes.data(), bytes.size());
  return hash.value();
}

}  // namespace

void* writeChunk(btSerializer& serializer, const void* key, const std::string& bytes) {
  constexpr std::size_t kAligned = 8;  // Bullet's loader loses its place behind odd chunks
  void* const pointer = const_cast<void*>(key);
  if (serializer.findPointer(pointer)) return serializer.getUniquePointer(pointer);
  const std::size_t room = (bytes.size() + kAligned - 1) / kAligned * kAligned;
  btChunk* const chunk = serializer.allocate(1, static_cast<int>(room));
  std::memset(chunk->m_oldPtr, 0, room);
  std::memcpy(chunk->m_oldPtr, bytes.data(), bytes.size());
  serializer.finalizeChunk(chunk, "char", BT_ARRAY_CODE, pointer);
  return serializer.getUniquePointer(pointer);
}

void* contactsKey() {
  static char key = 0;
  return &key;
}

constexpr double kMostScaling = 1e9;  // of records; bounds stay finite in float

std::string whyNotKept(const CloudShape& shape) {
  if (shape.field().unsettled() > 0)
    return "edges of a cut are still to be searched: call CuttableBody::settle() before saving";
  try {
    ShapeRecord::of(shape).bytes();
  } catch (const std::exception& why) {
    return why.what();
  }
  return {};
}

std::string sealed(const char* kind, const std::string& bytes) {
  ByteWriter writer;
  writer(static_cast<std::uint64_t>(bytes.size()), kVersion, hashOf(bytes));
  return kind + writer.bytes() + bytes;
}

std::span<const char> opened(const char* kind, const char* record, std::size_t room) {
  ByteReader reader({record, room});
  const std::span<const char> found = reader.take(kKindLength);
  if (std::string(found.data(), found.size()) != kind)
    throw std::runtime_error("a record is not of its kind");
  std::uint64_t length = 0, hash = 0;
  std::uint32_t version = 0;
  reader(length, version, hash);
  if (version != kVersion)
    throw std::runtime_error("a record is of version " + std::to_string(version) +
                             "; this program reads version " + std::to_string(kVersion));
  const std::span<const char> bytes = reader.take(length);
  if (hashOf(bytes) != hash)
    throw std::runtime_error("a record is damaged: its checksum does not match");
  return bytes;
}

ShapeRecord ShapeRecord::of(const CloudShape& shape) {
  ShapeRecord record;
  record.law = shape.law;
  record.tissues = shape.tissues_;
  record.tolerance = shape.fidelity_.tolerance;
  // A file does not tell that a field was renewed.
  record.exact = shape.fidelity_.exact || (shape.field_ && shape.field_->data().isRenewed());
  record.usesPaper = shape.asksPaper_;
  record.paper = shape.paperSettings_;
  if (shape.solid_) record.solid = shape.solid_->placed, record.solidVoxel = shape.solidVoxel_;
  record.margin = shape.margin_;
  record.scaling = toVec3(shape.scaling_);
  record.fieldScaling = shape.fieldScaling_;
  record.userIndex = shape.getUserIndex();
  return record;
}

std::string ShapeRecord::bytes() const {
  ByteWriter writer;
  ShapeRecord copy = *this;
  shapeIn(writer, copy);
  return writer.bytes();
}

ShapeRecord ShapeRecord::from(std::span<const char> bytes) {
  ByteReader reader(bytes);
  ShapeRecord record;
  shapeIn(reader, record);
  const auto isLength = [](double x) { return x >= 0 && x <= kMostScaling; };
  const auto isScaling = [&](double x) { return isLength(std::abs(x)); };
  if (!isLength(record.margin) || !(record.fieldScaling >= 1 / kMostScaling) ||
      !isLength(record.fieldScaling) || !isScaling(record.scaling.x()) ||
      !isScaling(record.scaling.y()) || !isScaling(record.scaling.z()))
    throw std::runtime_error("a record's margin or scaling is none that a shape can have");
  return record;
}

std::unique_ptr<CloudShape> ShapeRecord::make(std::shared_ptr<const SurfaceField> field) const {
  auto shape = std::make_unique<CloudShape>(std::move(field));
  shape->law = law;
  shape->setTissues(tissues);
  if (usesPaper) shape->usePaper(paper);
  shape->margin_ = static_cast<btScalar>(margin);
  shape->fieldScaling_ = fieldScaling;
  shape->setLocalScaling(toBullet(scaling));
  if (solid) shape->setSolid(*solid, solidVoxel);
  Fidelity fidelity;
  fidelity.tolerance = tolerance;
  fidelity.exact = exact && tolerance == 0;
  shape->setFidelity(fidelity);
  shape->setUserIndex(userIndex);
  return shape;
}

int CloudShape::calculateSerializeBufferSize() const {
  return sizeof(btTriangleMeshShapeData);
}

// Nothing may throw across Bullet: what cannot be kept is said where the file is read, and by
// saveWorld() before.
const char* CloudShape::serialize(void* buffer, btSerializer* serializer) const {
  auto& data = *static_cast<btTriangleMeshShapeData*>(buffer);
  std::memset(buffer, 0, sizeof data);
  btCollisionShape::serialize(&data.m_collisionShapeData, serializer);
  data.m_collisionMargin = static_cast<float>(margin_);
  ShapeRecord record;
  record.refused = whyNotKept(*this);
  if (record.refused.empty()) {
    record = ShapeRecord::of(*this);
    if (!serializer->findPointer(const_cast<SurfaceField*>(&field()))) {
      std::ostringstream bytes;
      writeField(field(), bytes);  // levels follow from it
      writeChunk(*serializer, &field(), bytes.str());
    }
  }
  // The law's address is no other chunk's.
  data.m_meshInterface.m_meshPartsPtr = static_cast<btMeshPartData*>(
      writeChunk(*serializer, &law, sealed(kShapeKind, record.bytes())));
  data.m_quantizedFloatBvh = static_cast<btQuantizedBvhFloatData*>(
      serializer->getUniquePointer(const_cast<SurfaceField*>(&field())));
  // Bullet's loader leaves a pointer to nothing as it is.
  if (serializer->findPointer(contactsKey()))
    data.m_quantizedDoubleBvh =
        static_cast<btQuantizedBvhDoubleData*>(serializer->getUniquePointer(contactsKey()));
  return "btTriangleMeshShapeData";
}

}  // namespace cloudcontact
