// Reads and writes digital objects: see object_file.h.
//
// Layout of version 3, little-endian: 8 bytes "CLDCNTCT", u32 3, u32 kind, u64 bytes of the
// payload, the payload, u64 FNV-1a of all bytes before it. The payload is the fields of the kind in
// the order of its header, each list after its length (u64), each name with a zero after it. An
// octree is stored as its voxels, a sphere tree as its leaves: both rebuild to equal trees.
#include <cloudcontact/objects/object_file.h>
#include <cloudcontact/voxels/cloud_file.h>

#include <sstream>
#include <stdexcept>

#include "voxels/cloud_bytes.h"

namespace cloudcontact {

namespace {

namespace fs = std::filesystem;

// Stored in files: never renumber.
enum class Kind : std::uint32_t { Points = 1, Spheres, Columns, Octree, SphereTree, DepthImage };

constexpr std::uint64_t kHeaderBytes = 8 + 4 + 4 + 8;

// Writes numbers, vectors and lists to a stream.
class Packer {
 public:
  explicit Packer(std::ostream& out) : writer_(out) {}
  template <typename Number>
  requires std::is_arithmetic_v<Number>
  void put(Number x) { writer_.number(x); }
  template <typename Number, int Size>
  void put(const Eigen::Matrix<Number, Size, 1>& v) {
    for (int k = 0; k < Size; ++k) put(v[k]);
  }
  void put(const std::string& name) { writer_.bytes(name.c_str(), name.size() + 1); }
  template <typename Number, std::size_t Size>
  void put(const std::array<Number, Size>& a) {
    for (const Number x : a) put(x);
  }
  void put(const ColumnInterval& i) { put(i.low), put(i.high), put(i.share), put(i.material); }
  void put(const SphereTree::Leaf& l) {
    put(l.center), put(l.radius), put(l.share), put(l.material), put(l.item);
  }
  template <typename Item>
  void put(const std::vector<Item>& list) {
    put(static_cast<std::uint64_t>(list.size()));
    for (const Item& item : list) put(item);
  }

 private:
  CloudWriter writer_;
};

Kind pack(Packer& p, const PointCloud& o) {
  validate(o);
  p.put(o.positions), p.put(o.spacing), p.put(o.shares), p.put(o.normals), p.put(o.material);
  p.put(o.materials);
  return Kind::Points;
}

Kind pack(Packer& p, const SphereCloud& o) {
  validate(o);
  p.put(o.centers), p.put(o.radii), p.put(o.material), p.put(o.materials);
  return Kind::Spheres;
}

Kind pack(Packer& p, const ColumnCloud& o) {
  validate(o);
  p.put(static_cast<std::int32_t>(o.axis)), p.put(o.width), p.put(o.origin), p.put(o.columns);
  p.put(std::vector<std::uint64_t>(o.first.begin(), o.first.end()));
  p.put(o.intervals), p.put(o.materials);
  return Kind::Columns;
}

Kind pack(Packer& p, const Octree& o) {
  const Cloud cloud = o.cloud();
  const Cloud::Voxels& v = cloud.voxels();
  p.put(cloud.voxelSize()), p.put(cloud.origin()), p.put(v.bricks), p.put(v.table);
  p.put(v.coverage), p.put(v.materials), p.put(v.materialTable), p.put(v.material);
  return Kind::Octree;
}

Kind pack(Packer& p, const SphereTree& o) {
  p.put(static_cast<std::uint8_t>(o.kind())), p.put(o.leaves()), p.put(o.materials());
  return Kind::SphereTree;
}

Kind pack(Packer& p, const DepthImage& o) {
  validate(o);
  p.put(static_cast<std::int32_t>(o.width)), p.put(static_cast<std::int32_t>(o.height));
  p.put(o.viewpoint), p.put(o.points);
  return Kind::DepthImage;
}

// Reads them from a stream. Before a list is allocated, its length is checked against the remaining
// bytes.
class Unpacker {
 public:
  Unpacker(CloudReader& reader, std::uint64_t end) : reader_(reader), end_(end) {}
  template <typename Number>
  requires std::is_arithmetic_v<Number>
  void get(Number& x) {
    claim(sizeof(Number), 1);
    x = reader_.number<Number>();
  }
  template <typename Number, int Size>
  void get(Eigen::Matrix<Number, Size, 1>& v) {
    for (int k = 0; k < Size; ++k) get(v[k]);
  }
  void get(std::string& name) {
    name.clear();
    for (char c = 1; get(c), c != 0;) name += c;
  }
  template <typename Number, std::size_t Size>
  void get(std::array<Number, Size>& a) {
    for (Number& x : a) get(x);
  }
  void get(ColumnInterval& i) { get(i.low), get(i.high), get(i.share), get(i.material); }
  void get(SphereTree::Leaf& l) {
    get(l.center), get(l.radius), get(l.share), get(l.material), get(l.item);
  }
  template <typename Item>
  void get(std::vector<Item>& list) {
    std::uint64_t size = 0;
    get(size);
    claim(leastBytes(static_cast<const Item*>(nullptr)), size);
    list.resize(size);
    for (Item& item : list) get(item);
  }
  template <typename Item>
  Item take() {
    Item item;
    get(item);
    return item;
  }
  void finish() const {
    if (reader_.position() != end_)
      refuseCloudFile(reader_.file(), "says impossible sizes; save the object again");
  }

 private:
  template <typename Number, int Size>
  static std::uint64_t leastBytes(const Eigen::Matrix<Number, Size, 1>*) {
    return Size * sizeof(Number);
  }
  template <typename Number, std::size_t Size>
  static std::uint64_t leastBytes(const std::array<Number, Size>*) {
    return Size * sizeof(Number);
  }
  static std::uint64_t leastBytes(const std::string*) { return 1; }
  static std::uint64_t leastBytes(const ColumnInterval*) { return 8 + 8 + 4 + 1; }
  static std::uint64_t leastBytes(const SphereTree::Leaf*) { return 3 * 8 + 8 + 4 + 1 + 4; }
  template <typename Number>
  requires std::is_arithmetic_v<Number>
  static std::uint64_t leastBytes(const Number*) { return sizeof(Number); }
  void claim(std::uint64_t bytes, std::uint64_t count) const {
    if (count > (end_ - reader_.position()) / bytes)
      refuseCloudFile(reader_.file(), "says impossible sizes; save the object again");
  }
  CloudReader& reader_;
  std::uint64_t end_;
};

PointCloud pointsFrom(Unpacker& u) {
  PointCloud o;
  u.get(o.positions), u.get(o.spacing), u.get(o.shares), u.get(o.normals), u.get(o.material);
  u.get(o.materials);
  return o;
}

SphereCloud spheresFrom(Unpacker& u) {
  SphereCloud o;
  u.get(o.centers), u.get(o.radii), u.get(o.material), u.get(o.materials);
  return o;
}

ColumnCloud columnsFrom(Unpacker& u) {
  ColumnCloud o;
  o.axis = u.take<std::int32_t>();
  u.get(o.width), u.get(o.origin), u.get(o.columns);
  const auto first = u.take<std::vector<std::uint64_t>>();
  o.first.assign(first.begin(), first.end());
  u.get(o.intervals), u.get(o.materials);
  return o;
}

Cloud octreeFrom(Unpacker& u) {
  auto voxels = std::make_shared<Cloud::Voxels>();
  const auto size = u.take<double>();
  const auto origin = u.take<Vec3>();
  u.get(voxels->bricks), u.get(voxels->table), u.get(voxels->coverage), u.get(voxels->materials);
  u.get(voxels->materialTable), u.get(voxels->material);
  return Cloud(size, origin, std::move(voxels));
}

SphereTree treeFrom(Unpacker& u) {
  const auto kind = u.take<std::uint8_t>();
  if (kind > 1) throw std::invalid_argument("sphereTree: its leaves are of no known kind");
  auto leaves = u.take<std::vector<SphereTree::Leaf>>();
  auto materials = u.take<std::vector<std::string>>();
  return SphereTree(static_cast<SphereTree::Kind>(kind), std::move(leaves), std::move(materials));
}

DepthImage imageFrom(Unpacker& u) {
  DepthImage o;
  o.width = u.take<std::int32_t>();
  o.height = u.take<std::int32_t>();
  u.get(o.viewpoint), u.get(o.points);
  return o;
}

template <typename Object>
DigitalObject checked(Object object) {
  validate(object);
  return object;
}

// Builds the object only after all bytes are read and the checksum matches.
DigitalObject unpack(CloudReader& reader, std::uint32_t kind, std::uint64_t bytes) {
  Unpacker u(reader, reader.position() + bytes);
  const auto rest = [&](auto object) {
    u.finish();
    checkCloudHash(reader);
    return object;
  };
  switch (static_cast<Kind>(kind)) {
    case Kind::Points:
      return checked(rest(pointsFrom(u)));
    case Kind::Spheres:
      return checked(rest(spheresFrom(u)));
    case Kind::Columns:
      return checked(rest(columnsFrom(u)));
    case Kind::Octree:
      return Octree(rest(octreeFrom(u)));
    case Kind::SphereTree:
      return rest(treeFrom(u));
    case Kind::DepthImage:
      return checked(rest(imageFrom(u)));
  }
  refuseCloudFile(reader.file(), "holds a kind of object that is not known here; save it again");
}

}  // namespace

void saveObject(const DigitalObject& object, const fs::path& file) {
  if (const Cloud* cloud = std::get_if<Cloud>(&object)) return saveCloud(*cloud, file);
  std::ostringstream packed;
  Kind kind{};
  try {
    if (boundsOf(object).isEmpty()) throw std::invalid_argument("the object is empty");
    Packer packer(packed);
    kind = std::visit(
        [&](const auto& o) {
          if constexpr (std::is_same_v<std::decay_t<decltype(o)>, Cloud>)
            return Kind{};  // written above
          else
            return pack(packer, o);
        },
        object);
  } catch (const std::invalid_argument& e) {
    refuseCloudFile(file, std::string("not written: ") + e.what());
  }
  const std::string bytes = std::move(packed).str();
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
  std::ifstream in = openCloudFile(file);
  CloudReader reader(in, file);
  if (readCloudVersion(reader) != kAnyObject) return loadCloud(file);
  const auto kind = reader.number<std::uint32_t>();
  const auto bytes = reader.number<std::uint64_t>();
  const std::uint64_t length = fs::file_size(file);
  if (bytes > length) refuseCloudFile(file, "says impossible sizes; save the object again");
  const std::uint64_t expected = kHeaderBytes + bytes + 8;
  if (length < expected)
    refuseCloudFile(file, "is cut short: " + std::to_string(length) + " bytes instead of " +
                              std::to_string(expected) + "; save the object again");
  if (length > expected)
    refuseCloudFile(file,
                    "has " + std::to_string(length - expected) + " bytes too many; save it again");
  try {
    return unpack(reader, kind, bytes);
  } catch (const std::invalid_argument& e) {
    refuseCloudFile(file, e.what());
  }
}

}  // namespace cloudcontact
