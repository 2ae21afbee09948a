// Reads and writes digital objects: see object_file.h.
//
// Layout of version 3, little-endian: 8 bytes "CLDCNTCT", u32 3, u32 kind, u64 bytes of the
// payload, the payload, u64 FNV-1a of all bytes before it. The payload is the fields of the kind in
// the order of its header, each list after its length (u64), each name with a zero after it. An
// octree is stored as its voxels, a sphere tree as its leaves: both rebuild to equal trees.
#include <cloudcontact/objects/object_file.h>
#include <cloudcontact/voxels/cloud_file.h>

#include <optional>
#include <stdexcept>
#include <type_traits>

#include "base/byte_archive.h"
#include "voxels/cloud_bytes.h"

namespace cloudcontact {

namespace {

namespace fs = std::filesystem;

// Stored in files: never renumber.
enum class Kind : std::uint32_t { Points = 1, Spheres, Columns, Octree, SphereTree, DepthImage };

constexpr std::uint64_t kHeaderBytes = 8 + 4 + 4 + 8;

// One function for each kind names its fields, for writing and for reading (base/byte_archive.h).
template <typename Archive, typename Value>
void in(Archive& archive, Value& value) {
  archive(value);
}
template <typename Archive, typename Interval>
requires std::is_same_v<std::remove_const_t<Interval>, ColumnInterval>
void in(Archive& archive, Interval& i) {
  archive(i.low, i.high, i.share, i.material);
}
template <typename Archive, typename Leaf>
requires std::is_same_v<std::remove_const_t<Leaf>, SphereTree::Leaf>
void in(Archive& archive, Leaf& l) {
  archive(l.center, l.radius, l.share, l.material, l.item);
}
void in(ByteWriter& archive, const std::string& name) {
  for (const char c : name) archive(c);
  archive('\0');
}
void in(ByteReader& archive, std::string& name) {
  name.clear();
  for (char c = 1; archive(c), c != 0;) name += c;
}
void in(ByteWriter& archive, const BrickCoverage& numbers) {
  for (const std::uint8_t x : numbers) archive(x);
}
void in(ByteReader& archive, BrickCoverage& numbers) {
  for (std::uint8_t& x : numbers) archive(x);
}

template <typename Archive, typename... Lists>
void listsIn(Archive& archive, Lists&... lists) {
  (listIn(archive, lists, [](Archive& a, auto& item) { in(a, item); }), ...);
}

template <typename Archive, typename Object>
void pointsIn(Archive& archive, Object& o) {
  listsIn(archive, o.positions);
  archive(o.spacing);
  listsIn(archive, o.shares, o.normals, o.material, o.materials);
}

template <typename Archive, typename Object>
void spheresIn(Archive& archive, Object& o) {
  listsIn(archive, o.centers, o.radii, o.material, o.materials);
}

template <typename Archive, typename Object>
void columnsIn(Archive& archive, Object& o) {
  static_assert(sizeof o.axis == 4 && sizeof o.first[0] == 8);
  archive(o.axis, o.width, o.origin, o.columns);
  listsIn(archive, o.first, o.intervals, o.materials);
}

template <typename Archive, typename Length, typename Vector, typename Voxels>
void voxelsIn(Archive& archive, Length& voxelSize, Vector& origin, Voxels& v) {
  archive(voxelSize, origin, v.bricks);
  listsIn(archive, v.table, v.coverage, v.materials, v.materialTable, v.material);
}

template <typename Archive, typename Object>
void imageIn(Archive& archive, Object& o) {
  static_assert(sizeof o.width == 4);
  archive(o.width, o.height, o.viewpoint);
  listsIn(archive, o.points);
}

Kind pack(ByteWriter& writer, const PointCloud& o) {
  validate(o);
  pointsIn(writer, o);
  return Kind::Points;
}
Kind pack(ByteWriter& writer, const SphereCloud& o) {
  validate(o);
  spheresIn(writer, o);
  return Kind::Spheres;
}
Kind pack(ByteWriter& writer, const ColumnCloud& o) {
  validate(o);
  columnsIn(writer, o);
  return Kind::Columns;
}
Kind pack(ByteWriter& writer, const Octree& o) {
  const Cloud cloud = o.cloud();
  const double voxelSize = cloud.voxelSize();
  voxelsIn(writer, voxelSize, cloud.origin(), cloud.voxels());
  return Kind::Octree;
}
Kind pack(ByteWriter& writer, const SphereTree& o) {
  writer(static_cast<std::uint8_t>(o.kind()));
  listsIn(writer, o.leaves(), o.materials());
  return Kind::SphereTree;
}
Kind pack(ByteWriter& writer, const DepthImage& o) {
  validate(o);
  imageIn(writer, o);
  return Kind::DepthImage;
}
Kind pack(ByteWriter&, const Cloud&) {
  return {};  // has files of its own
}

Octree octreeFrom(ByteReader& reader) {
  auto voxels = std::make_shared<Cloud::Voxels>();
  double voxelSize = 0;
  Vec3 origin;
  voxelsIn(reader, voxelSize, origin, *voxels);
  return Octree(Cloud(voxelSize, origin, std::move(voxels)));
}

SphereTree treeFrom(ByteReader& reader) {
  std::uint8_t kind = 0;
  std::vector<SphereTree::Leaf> leaves;
  std::vector<std::string> materials;
  reader(kind);
  if (kind > 1) throw std::invalid_argument("sphereTree: its leaves are of no known kind");
  listsIn(reader, leaves, materials);
  return SphereTree(static_cast<SphereTree::Kind>(kind), std::move(leaves), std::move(materials));
}

template <typename Object>
Object objectFrom(ByteReader& reader, void (*fieldsIn)(ByteReader&, Object&)) {
  Object object;
  fieldsIn(reader, object);
  validate(object);
  return object;
}

DigitalObject unpack(ByteReader& reader, Kind kind) {
  switch (kind) {
    case Kind::Points:
      return objectFrom<PointCloud>(reader, &pointsIn);
    case Kind::Spheres:
      return objectFrom<SphereCloud>(reader, &spheresIn);
    case Kind::Columns:
      return objectFrom<ColumnCloud>(reader, &columnsIn);
    case Kind::Octree:
      return octreeFrom(reader);
    case Kind::SphereTree:
      return treeFrom(reader);
    case Kind::DepthImage:
      return objectFrom<DepthImage>(reader, &imageIn);
  }
  throw std::invalid_argument("holds a kind of object that is not known here; save it again");
}

}  // namespace

void saveObject(const DigitalObject& object, const fs::path& file) {
  if (const Cloud* cloud = std::get_if<Cloud>(&object)) return saveCloud(*cloud, file);
  ByteWriter packed;
  Kind kind{};
  try {
    if (boundsOf(object).isEmpty()) throw std::invalid_argument("the object is empty");
    kind = std::visit([&](const auto& o) { return pack(packed, o); }, object);
  } catch (const std::invalid_argument& e) {
    refuseFile(file, std::string("not written: ") + e.what());
  }
  const std::string& bytes = packed.bytes();
  writeWhole(file, [&](std::ostream& out) {
    CloudWriter writer(out);
    writer.bytes(kCloudMagic, sizeof(kCloudMagic));
    writer.number(kAnyObject);
    writer.number(static_cast<std::uint32_t>(kind));
    writer.number(static_cast<std::uint64_t>(bytes.size()));
    writer.bytes(bytes.data(), bytes.size());
    writer.number(writer.hash());
  });
}

DigitalObject loadObject(const fs::path& file) {
  std::ifstream in = openFile(file, "a .cloud file");
  CloudReader reader(in, file);
  if (readCloudVersion(reader) != kAnyObject) return loadCloud(file);
  const auto kind = reader.number<std::uint32_t>();
  const auto bytes = reader.number<std::uint64_t>();
  const std::uint64_t length = fs::file_size(file);
  if (bytes > length) refuseFile(file, "says impossible sizes; save the object again");
  checkLength(file, length, kHeaderBytes + bytes + 8, "; save the object again");
  std::string payload(bytes, '\0');
  reader.bytes(payload.data(), payload.size());
  ByteReader fields(payload);
  std::optional<DigitalObject> object;
  try {
    object = unpack(fields, static_cast<Kind>(kind));
  } catch (const std::invalid_argument& e) {
    checkCloudHash(reader);  // damage is the likelier cause
    refuseFile(file, e.what());
  } catch (const std::runtime_error&) {
    refuseFile(file, "says impossible sizes; save the object again");
  }
  if (fields.left() > 0) refuseFile(file, "says impossible sizes; save the object again");
  checkCloudHash(reader);
  return std::move(*object);
}

}  // namespace cloudcontact
