// Reads and writes surface fields: see field_file.h.
//
// Layout of version 3, all little-endian: 8 bytes "CLDFIELD", u32 3, u64 bytes of the file, f64
// voxel size [m], f64 x 3 origin [m], i32 x 3 bricks, u64 band voxels, then arrays, each after its
// length (u64): the materials' names with a zero after each, the cloud's arrays, those of
// FieldRecords and of SampleSet, in the order of forEachArray(). At the end u64 WordHash of all
// bytes before it. Arrays go straight to and from memory: a checksum byte by byte alone would take
// longer than all the rest.
#include <cloudcontact/field/field_file.h>

#include "base/hash.h"
#include "field/field_bytes.h"
#include "field/field_data.h"
#include "field/sample_check.h"
#include "voxels/cloud_bytes.h"

#include <algorithm>
#include <cstring>
#include <vector>

namespace cloudcontact {

namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kVersion = 3;
constexpr const char* kAgain = "; build the field and save it again";

struct Header {
  double voxelSize = 0;
  Vec3 origin = Vec3::Zero();
  Eigen::Vector3i bricks = Eigen::Vector3i::Zero();
  std::uint64_t bandVoxels = 0;
};

// What a field consists of, as it is read.
struct Parts {
  std::string names;
  Cloud::Voxels voxels;
  FieldRecords records;
  SampleSet samples;
};

template <typename Samples, typename Visit>
void forEachSampleArray(Samples& samples, Visit&& visit) {
  for (auto& level : samples.levels) {
    auto& s = level.samples;
    visit(s.x), visit(s.y), visit(s.z), visit(s.nx), visit(s.ny), visit(s.nz);
    visit(s.area), visit(s.width), visit(level.clusters.rise);
    for (auto& column : level.clusters.spread) visit(column);
    visit(level.cellOf), visit(level.finer);
  }
  auto& b = samples.bricks;
  visit(b.x), visit(b.y), visit(b.z), visit(b.radius), visit(b.runs);
}

template <typename Names, typename Voxels, typename Records, typename Samples, typename Visit>
void forEachArray(Names& names, Voxels& voxels, Records& records, Samples& samples, Visit&& visit) {
  visit(names), visit(voxels.table), visit(voxels.coverage);
  visit(voxels.materialTable), visit(voxels.material);
  FieldRecords::forEachArray(records, visit);
  forEachSampleArray(samples, visit);
}

// An array's bytes with the lowest of each number first; its own inverse.
template <typename Item>
void orderBytes(Item* items, std::size_t count) {
  if constexpr (std::endian::native == std::endian::big && alignof(Item) > 1) {
    constexpr std::size_t kSize = alignof(Item);  // of a number
    auto* const bytes = reinterpret_cast<unsigned char*>(items);
    for (std::size_t at = 0; at < count * sizeof(Item); at += kSize)
      for (std::size_t i = 0; i < kSize / 2; ++i)
        std::swap(bytes[at + i], bytes[at + kSize - 1 - i]);
  }
}

template <typename Array>
std::uint64_t bytesOf(const Array& array) {
  return array.size() * sizeof(array[0]);
}

class FieldWriter : public HashedWriter<WordHash> {
 public:
  using HashedWriter::HashedWriter;
  template <typename Array>
  void array(const Array& all) {
    number(static_cast<std::uint64_t>(all.size()));
    if constexpr (std::endian::native == std::endian::little) {
      bytes(all.data(), bytesOf(all));
    } else {
      Array turned = all;
      orderBytes(turned.data(), turned.size());
      bytes(turned.data(), bytesOf(turned));
    }
  }
};

class Reader : public HashedReader<WordHash> {
 public:
  Reader(std::istream& in, const fs::path& file, std::uint64_t size)
      : HashedReader(in, file, kAgain), size_(size) {}
  std::uint64_t size() const { return size_; }
  // Nothing is allocated that the file cannot hold. By parts that stay in the cache: memory that is
  // filled with zeros first, and read once more for the checksum, took a fifth of a load.
  template <typename Array>
  void array(Array& all) {
    using Item = typename Array::value_type;
    constexpr std::size_t kPart = 4096;  // whole words of the checksum
    const auto count = number<std::uint64_t>();
    if (count > (size_ - position()) / sizeof(Item)) impossible();
    all.clear();
    all.reserve(count);
    std::vector<Item> part(std::min<std::size_t>(count, kPart));
    for (std::size_t left = count; left > 0; left -= part.size()) {
      part.resize(std::min<std::size_t>(left, kPart));
      bytes(part.data(), bytesOf(part));
      orderBytes(part.data(), part.size());
      all.insert(all.end(), part.begin(), part.end());
    }
  }
  [[noreturn]] void impossible() const { refuse("says impossible sizes"); }

 private:
  std::uint64_t size_;
};

void write(const FieldData& field, std::ostream& out) {
  const Cloud& cloud = field.cloud();
  std::string names;
  for (const std::string& name : cloud.voxels().materials) names += name + '\0';
  std::uint64_t length = sizeof kFieldMagic + 4 + 8 + 4 * 8 + 3 * 4 + 8 + 8;
  forEachArray(names, cloud.voxels(), field.records(), field.samples(),
               [&](const auto& array) { length += 8 + bytesOf(array); });
  FieldWriter writer(out);
  writer.bytes(kFieldMagic, sizeof kFieldMagic);
  writer.number(kVersion);
  writer.number(length);
  writer.number(cloud.voxelSize());
  for (int k = 0; k < 3; ++k) writer.number(cloud.origin()[k]);
  for (int k = 0; k < 3; ++k) writer.number(static_cast<std::int32_t>(cloud.bricks()[k]));
  writer.number(static_cast<std::uint64_t>(field.records().bandVoxels()));
  forEachArray(names, cloud.voxels(), field.records(), field.samples(),
               [&](const auto& array) { writer.array(array); });
  writer.checksum();
}

Header readHeader(Reader& reader, const fs::path& file) {
  const std::uint64_t length = reader.size();
  char magic[sizeof kFieldMagic] = {};
  reader.bytes(magic, sizeof magic);
  if (std::memcmp(magic, kFieldMagic, sizeof magic) != 0)
    refuseFile(file, "is not a surface field");
  const auto version = reader.number<std::uint32_t>();
  if (version != kVersion)
    refuseFile(file, "is a field of version " + std::to_string(version) +
                         "; this program reads version " + std::to_string(kVersion) + kAgain);
  checkLength(file, length, reader.number<std::uint64_t>(), kAgain);
  Header header;
  header.voxelSize = reader.number<double>();
  for (int k = 0; k < 3; ++k) header.origin[k] = reader.number<double>();
  for (int k = 0; k < 3; ++k) header.bricks[k] = reader.number<std::int32_t>();
  header.bandVoxels = reader.number<std::uint64_t>();
  return header;
}

void splitNames(const std::string& names, std::vector<std::string>& list) {
  for (std::size_t at = 0, end; (end = names.find('\0', at)) != std::string::npos; at = end + 1)
    list.push_back(names.substr(at, end - at));
}

}  // namespace

void saveField(const SurfaceField& field, const fs::path& file) {
  if (field.unsettled() > 0)
    refuseFile(file, "not written: edges at " + std::to_string(field.unsettled()) +
                         " voxels are still to be searched; renew the field until it is "
                         "settled");
  writeWhole(file, [&](std::ostream& out) { write(field.data(), out); });
}

void writeField(const SurfaceField& field, std::ostream& out) {
  write(field.data(), out);
}

std::shared_ptr<const SurfaceField> readField(std::istream& in, std::uint64_t size,
                                              const fs::path& file) {
  Reader reader(in, file, size);
  const Header header = readHeader(reader, file);
  Parts parts;
  forEachArray(parts.names, parts.voxels, parts.records, parts.samples,
               [&](auto& array) { reader.array(array); });
  reader.checksum();
  parts.voxels.bricks = header.bricks;
  splitNames(parts.names, parts.voxels.materials);
  try {
    Cloud cloud(header.voxelSize, header.origin,
                std::make_shared<Cloud::Voxels>(std::move(parts.voxels)));
    if (!parts.records.complete(cloud.bricks(), header.bandVoxels) ||
        !consistent(parts.samples, cloud.size()))
      reader.impossible();
    return std::make_shared<const SurfaceField>(std::make_shared<const FieldData>(
        std::move(cloud), std::move(parts.records), std::move(parts.samples)));
  } catch (const std::invalid_argument& e) {
    refuseFile(file, e.what());
  }
}

std::shared_ptr<const SurfaceField> loadField(const fs::path& file) {
  std::ifstream in = openFile(file, "a .field file");
  return readField(in, fs::file_size(file), file);
}

}  // namespace cloudcontact
