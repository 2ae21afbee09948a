// Clouds kept in files: see cloud_file.h.
//
// Layout, all little-endian: 8 bytes "CLDCNTCT", u32 version, f64 voxel size [m], f64 x 3 origin
// [m], i32 x 3 bricks, u64 stored bricks, the table (i32 each), the stored bricks (512 bytes each),
// u64 FNV-1a of everything before it. Version 2 is for bodies of several materials: behind the
// stored bricks' number u64 bytes of names and u64 bricks of materials; behind the stored bricks
// the names, a zero behind each, the table of materials (i32 each) and those bricks (512 bytes
// each).
#include <cloudcontact/cloud_file.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>

namespace cloudcontact {

namespace {

namespace fs = std::filesystem;

constexpr char kMagic[8] = {'C', 'L', 'D', 'C', 'N', 'T', 'C', 'T'};
constexpr std::uint32_t kPlain = 1, kWithMaterials = 2;  // versions
constexpr std::uint64_t kHeaderBytes = 8 + 4 + 4 * 8 + 3 * 4 + 8, kMaterialHeader = 2 * 8;

[[noreturn]] void refuse(const fs::path& file, const std::string& why) {
  throw std::runtime_error(file.string() + ": " + why);
}

// Bytes go through here on their way to the file or from it, so that the hash sees them all.
class Hash {
 public:
  void add(const void* data, std::size_t bytes) {
    const auto* p = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < bytes; ++i) value_ = (value_ ^ p[i]) * 0x100000001B3ull;
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xCBF29CE484222325ull;
};

// The number with its lowest byte first, whatever the machine; its own inverse.
template <typename Number>
Number littleEndian(Number x) {
  if constexpr (std::endian::native == std::endian::big) {
    auto* bytes = reinterpret_cast<unsigned char*>(&x);
    for (std::size_t i = 0; i < sizeof(x) / 2; ++i) std::swap(bytes[i], bytes[sizeof(x) - 1 - i]);
  }
  return x;
}

class Writer {
 public:
  explicit Writer(std::ostream& out) : out_(out) {}
  void bytes(const void* data, std::size_t count) {
    hash_.add(data, count);
    out_.write(static_cast<const char*>(data), static_cast<std::streamsize>(count));
  }
  template <typename Number>
  void number(Number x) {
    x = littleEndian(x);
    bytes(&x, sizeof(x));
  }
  std::uint64_t hash() const { return hash_.value(); }

 private:
  std::ostream& out_;
  Hash hash_;
};

class Reader {
 public:
  Reader(std::istream& in, const fs::path& file) : in_(in), file_(file) {}
  void bytes(void* data, std::size_t count) {
    in_.read(static_cast<char*>(data), static_cast<std::streamsize>(count));
    if (!in_) refuse(file_, "is cut short; save the cloud again");
    hash_.add(data, count);
  }
  template <typename Number>
  Number number() {
    Number x;
    bytes(&x, sizeof(x));
    return littleEndian(x);
  }
  std::uint64_t hash() const { return hash_.value(); }

 private:
  std::istream& in_;
  const fs::path& file_;
  Hash hash_;
};

void write(const Cloud& cloud, std::ostream& out) {
  Writer writer(out);
  const Cloud::Voxels& voxels = cloud.voxels();
  writer.bytes(kMagic, sizeof(kMagic));
  const bool materials = !voxels.materials.empty();
  std::string names;
  for (const std::string& name : voxels.materials) names += name + '\0';
  writer.number(materials ? kWithMaterials : kPlain);
  writer.number(cloud.voxelSize());
  for (int k = 0; k < 3; ++k) writer.number(cloud.origin()[k]);
  for (int k = 0; k < 3; ++k) writer.number(static_cast<std::int32_t>(voxels.bricks[k]));
  writer.number(static_cast<std::uint64_t>(voxels.coverage.size()));
  if (materials) {
    writer.number(static_cast<std::uint64_t>(names.size()));
    writer.number(static_cast<std::uint64_t>(voxels.material.size()));
  }
  for (const std::int32_t b : voxels.table) writer.number(b);
  for (const BrickCoverage& b : voxels.coverage) writer.bytes(b.data(), b.size());
  writer.bytes(names.data(), names.size());
  for (const std::int32_t m : voxels.materialTable) writer.number(m);
  for (const BrickMaterial& m : voxels.material) writer.bytes(m.data(), m.size());
  writer.number(writer.hash());
}

struct Header {
  double voxelSize;
  Vec3 origin;
  Eigen::Vector3i bricks;
  std::uint64_t tableEntries, storedBricks;
  bool materials = false;
  std::uint64_t nameBytes = 0, materialBricks = 0;
};

Header readHeader(Reader& reader, const fs::path& file) {
  char magic[8];
  reader.bytes(magic, sizeof(magic));
  if (std::memcmp(magic, kMagic, sizeof(magic)) != 0)
    refuse(file, "is not a cloud; make one with `cloudcontact digitize`");
  const auto version = reader.number<std::uint32_t>();
  if (version != kPlain && version != kWithMaterials)
    refuse(file, "is a cloud of version " + std::to_string(version) +
                     ", this program reads 1 and 2" + "; digitize the body again");
  Header header;
  header.materials = version == kWithMaterials;
  header.voxelSize = reader.number<double>();
  for (int k = 0; k < 3; ++k) header.origin[k] = reader.number<double>();
  for (int k = 0; k < 3; ++k) header.bricks[k] = reader.number<std::int32_t>();
  header.storedBricks = reader.number<std::uint64_t>();
  if (header.materials) {
    header.nameBytes = reader.number<std::uint64_t>();
    header.materialBricks = reader.number<std::uint64_t>();
  }
  header.tableEntries = 1;
  for (int k = 0; k < 3; ++k) {
    if (header.bricks[k] < 0) refuse(file, "says a negative number of bricks; save it again");
    const std::uint64_t n = static_cast<std::uint64_t>(header.bricks[k]);
    if (n != 0 && header.tableEntries > std::numeric_limits<std::uint32_t>::max() / n)
      refuse(file, "says impossible sizes; save it again");
    header.tableEntries *= n;
  }
  return header;
}

// A file says its sizes itself; they must be its length before anything is allocated for them.
void checkLength(const Header& header, const fs::path& file) {
  const std::uint64_t length = fs::file_size(file);
  if (std::max(header.storedBricks, header.materialBricks) > header.tableEntries)
    refuse(file, "says impossible sizes: more stored bricks than places; save it again");
  if (header.nameBytes > length) refuse(file, "says impossible sizes: its names; save it again");
  std::uint64_t expected =
      kHeaderBytes + 4 * header.tableEntries + kBrickVoxels * header.storedBricks + 8;
  if (header.materials)
    expected += kMaterialHeader + header.nameBytes + 4 * header.tableEntries +
                kBrickVoxels * header.materialBricks;
  if (length < expected)
    refuse(file, "is cut short: " + std::to_string(length) + " bytes instead of " +
                     std::to_string(expected) + "; save the cloud again");
  if (length > expected)
    refuse(file, "has " + std::to_string(length - expected) + " bytes too many; save it again");
}

void readMaterials(Reader& reader, const Header& header, Cloud::Voxels& voxels) {
  std::string names(header.nameBytes, '\0');
  reader.bytes(names.data(), names.size());
  for (std::size_t at = 0, end; (end = names.find('\0', at)) != std::string::npos; at = end + 1)
    voxels.materials.push_back(names.substr(at, end - at));
  voxels.materialTable.resize(header.tableEntries);
  for (std::int32_t& m : voxels.materialTable) m = reader.number<std::int32_t>();
  voxels.material.resize(header.materialBricks);
  for (BrickMaterial& m : voxels.material) reader.bytes(m.data(), m.size());
}

// Removes a half-written file on every way out but the good one.
class Temporary {
 public:
  explicit Temporary(const fs::path& target) : path_(target) {
    path_ += "." + std::to_string(std::random_device()()) + ".part";
  }
  ~Temporary() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

void saveCloud(const Cloud& cloud, const fs::path& file) {
  if (cloud.empty()) refuse(file, "not written: the cloud is empty");
  if (fs::is_directory(file)) refuse(file, "is a directory; give the name of a file");
  const Temporary temporary(file);
  std::ofstream out(temporary.path(), std::ios::binary);
  if (!out) refuse(file, "cannot be written; check that its folder exists and may be written to");
  write(cloud, out);
  out.close();
  if (!out) refuse(file, "could not be written whole; check the space that is left");
  std::error_code error;
  fs::rename(temporary.path(), file, error);
  if (error) refuse(file, "cannot be replaced: " + error.message());
}

Cloud loadCloud(const fs::path& file) {
  if (!fs::exists(file)) refuse(file, "no such file");
  if (!fs::is_regular_file(file)) refuse(file, "is not a file; give a .cloud file");
  std::ifstream in(file, std::ios::binary);
  if (!in) refuse(file, "cannot be read; check its permissions");
  Reader reader(in, file);
  const Header header = readHeader(reader, file);
  checkLength(header, file);
  auto voxels = std::make_shared<Cloud::Voxels>();
  voxels->bricks = header.bricks;
  voxels->table.resize(header.tableEntries);
  for (std::int32_t& b : voxels->table) b = reader.number<std::int32_t>();
  voxels->coverage.resize(header.storedBricks);
  for (BrickCoverage& b : voxels->coverage) reader.bytes(b.data(), b.size());
  if (header.materials) readMaterials(reader, header, *voxels);
  const std::uint64_t hash = reader.hash();
  if (reader.number<std::uint64_t>() != hash)
    refuse(file, "is damaged: its bytes do not add up; save the cloud again");
  try {
    return Cloud(header.voxelSize, header.origin, std::move(voxels));
  } catch (const std::invalid_argument& e) {
    refuse(file, e.what());
  }
}

}  // namespace cloudcontact
