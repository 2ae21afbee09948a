// Reads and writes clouds: see cloud_file.h.
//
// Layout, all little-endian: 8 bytes "CLDCNTCT", u32 version, f64 voxel size [m], f64 x 3 origin
// [m], i32 x 3 bricks, u64 stored bricks, the table (i32 each), the stored bricks (512 bytes each),
// u64 FNV-1a of all bytes before it. Version 2 is for bodies of several materials. It adds, after
// the number of stored bricks, u64 bytes of names and u64 bricks of materials; after the stored
// bricks, the names with a zero after each, the table of materials (i32 each) and those bricks (512
// bytes each). Version 3 is in objects/object_file.cpp.
#include <cloudcontact/voxels/cloud_file.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include "voxels/cloud_bytes.h"

namespace cloudcontact {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kHeaderBytes = 8 + 4 + 4 * 8 + 3 * 4 + 8, kMaterialHeader = 2 * 8;

void write(const Cloud& cloud, std::ostream& out) {
  CloudWriter writer(out);
  const Cloud::Voxels& voxels = cloud.voxels();
  writer.bytes(kCloudMagic, sizeof(kCloudMagic));
  const bool materials = !voxels.materials.empty();
  std::string names;
  for (const std::string& name : voxels.materials) names += name + '\0';
  writer.number(materials ? kCloudWithMaterials : kPlainCloud);
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

Header readHeader(CloudReader& reader, const fs::path& file) {
  const std::uint32_t version = readCloudVersion(reader);
  if (version == kAnyObject)
    refuseFile(file, "holds another kind of object than voxels; load it as an object");
  Header header;
  header.materials = version == kCloudWithMaterials;
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
    if (header.bricks[k] < 0) refuseFile(file, "says a negative number of bricks; save it again");
    const std::uint64_t n = static_cast<std::uint64_t>(header.bricks[k]);
    if (n != 0 && header.tableEntries > std::numeric_limits<std::uint32_t>::max() / n)
      refuseFile(file, "says impossible sizes; save it again");
    header.tableEntries *= n;
  }
  return header;
}

// The sizes in the header must match the length of the file before anything is allocated.
void checkSizes(const Header& header, const fs::path& file) {
  if (std::max(header.storedBricks, header.materialBricks) > header.tableEntries)
    refuseFile(file, "says impossible sizes: more stored bricks than places; save it again");
  if (header.nameBytes > fs::file_size(file))
    refuseFile(file, "says impossible sizes: its names; save it again");
  std::uint64_t expected =
      kHeaderBytes + 4 * header.tableEntries + kBrickVoxels * header.storedBricks + 8;
  if (header.materials)
    expected += kMaterialHeader + header.nameBytes + 4 * header.tableEntries +
                kBrickVoxels * header.materialBricks;
  checkLength(file, fs::file_size(file), expected, "; save the cloud again");
}

void readMaterials(CloudReader& reader, const Header& header, Cloud::Voxels& voxels) {
  std::string names(header.nameBytes, '\0');
  reader.bytes(names.data(), names.size());
  for (std::size_t at = 0, end; (end = names.find('\0', at)) != std::string::npos; at = end + 1)
    voxels.materials.push_back(names.substr(at, end - at));
  voxels.materialTable.resize(header.tableEntries);
  for (std::int32_t& m : voxels.materialTable) m = reader.number<std::int32_t>();
  voxels.material.resize(header.materialBricks);
  for (BrickMaterial& m : voxels.material) reader.bytes(m.data(), m.size());
}

}  // namespace

void saveCloud(const Cloud& cloud, const fs::path& file) {
  if (cloud.empty()) refuseFile(file, "not written: the cloud is empty");
  writeWhole(file, [&](std::ostream& out) { write(cloud, out); });
}

Cloud loadCloud(const fs::path& file) {
  std::ifstream in = openFile(file, "a .cloud file");
  CloudReader reader(in, file);
  const Header header = readHeader(reader, file);
  checkSizes(header, file);
  auto voxels = std::make_shared<Cloud::Voxels>();
  voxels->bricks = header.bricks;
  voxels->table.resize(header.tableEntries);
  for (std::int32_t& b : voxels->table) b = reader.number<std::int32_t>();
  voxels->coverage.resize(header.storedBricks);
  for (BrickCoverage& b : voxels->coverage) reader.bytes(b.data(), b.size());
  if (header.materials) readMaterials(reader, header, *voxels);
  checkCloudHash(reader);
  try {
    return Cloud(header.voxelSize, header.origin, std::move(voxels));
  } catch (const std::invalid_argument& e) {
    refuseFile(file, e.what());
  }
}

}  // namespace cloudcontact
