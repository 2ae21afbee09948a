// Files of meshes, points and volumes, and what is made of them. The first byte of an input says
// the format, the rest is the file.
#include <cloudcontact/mesh/mesh_file.h>
#include <cloudcontact/mesh/mesh_repair.h>
#include <cloudcontact/objects/digital_object.h>
#include <cloudcontact/objects/point_file.h>
#include <cloudcontact/voxels/digitize.h>
#include <cloudcontact/voxels/volume_file.h>

#include <iterator>
#include <sstream>

#include "fuzz/fuzz_input.h"
#include "fuzz/fuzz_target.h"

namespace cloudcontact::fuzz {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = std::size_t{1} << 20;

fs::path fileOf(std::string_view input, const std::vector<const char*>& formats) {
  const auto format = input.empty() ? 0 : static_cast<unsigned char>(input[0]) % formats.size();
  return inputFile(std::string("input.") + formats[format], input.substr(input.empty() ? 0 : 1));
}

void useMesh(const Mesh& mesh) {
  if (mesh.triangles.size() > 200) return;
  inspect(mesh);
  const Mesh whole = mended(mesh);
  mayRefuse("", [&] {
    const double voxel = 8 * suggestedVoxel(mesh);
    digitizeSmall(whole, voxel);
  });
}

// Assimp is not ours: its own reader sees only what ours have found to be whole, so STL and PLY.
void readMesh(std::string_view input) {
  const fs::path file = fileOf(input, {"stl", "ply"});
  mayRefuse("input.", [&] { useMesh(loadMesh(file, 0.001)); });
}

void usePoints(PointCloud points) {
  validate(points);
  if (points.positions.size() > 300) return;
  recognizeVolume(points);
  // Points far from the rest take up to 2 GB, as documented.
  const Vec3 size = boundsOf(points).sizes() / pointDistance(points);
  if (!(size.maxCoeff() < 100)) return;
  mayRefuse("", [&] {
    ScanSettings settings;
    settings.voxelSize = 4 * suggestedVoxel(points);
    settings.shell = 3 * settings.voxelSize;
    settings.threads = 1;
    points.fillsVolume() ? toCloud(points, settings.voxelSize) : toCloud(points, settings);
  });
}

void usePoints(const DepthImage& image) {
  if (image.points.size() > 300) return;
  mayRefuse("", [&] { mended(image); });
  mayRefuse("", [&] { toMesh(image); });
}

void readPoints(std::string_view input) {
  const fs::path file = fileOf(input, {"ply", "pcd", "xyz"});
  isPointFile(file);
  mayRefuse("input.", [&] {
    std::visit([](auto points) { usePoints(std::move(points)); }, loadPoints(file, 0.001));
  });
}

void readVolume(std::string_view input) {
  const fs::path file = fileOf(input, {"nrrd", "mha", "nhdr", "mhd"});
  CtVolume volume;
  for (const double voxel : {0.01, 0.0})
    mayRefuse("input.", [&] {
      volume =
          loadVolume(file, {.metersPerUnit = 0.001, .voxelSize = voxel, .maxBytes = kMostBytes});
    });
  if (volume.values.empty() || volume.values.size() > 4096) return;
  mayRefuse("cloudFromCt", [&] {
    cloudFromCt(volume, {{0.5, "soft"}, {100, "hard"}},
                {.voxelSize = 0, .maxBytes = kMostBytes / 32});
  });
}

std::string withFormat(char format, const std::string& file) {
  return format + file;
}

std::string stlText(const Mesh& mesh) {
  std::ostringstream out;
  out << "solid part\n";
  for (const Eigen::Vector3i& t : mesh.triangles) {
    out << "facet normal 0 0 0\nouter loop\n";
    for (int k = 0; k < 3; ++k)
      out << "vertex " << mesh.vertices[static_cast<std::size_t>(t[k])].transpose() << "\n";
    out << "endloop\nendfacet\n";
  }
  out << "endsolid part\n";
  return out.str();
}

std::string stlBinary(const Mesh& mesh) {
  std::string file(80, ' ');
  add(file, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int k = -1; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis)
        add(file, k < 0 ? 0.0f : float(mesh.vertices[static_cast<std::size_t>(t[k])][axis]));
    add(file, std::uint16_t{0});
  }
  return file;
}

std::string plyText(const Mesh& mesh, bool faces) {
  std::ostringstream out;
  out << "ply\nformat ascii 1.0\nelement vertex " << mesh.vertices.size()
      << "\nproperty float x\nproperty float y\nproperty float z\n";
  if (faces)
    out << "element face " << mesh.triangles.size() << "\nproperty list uchar int vertex_indices\n";
  out << "end_header\n";
  for (const Vec3& v : mesh.vertices) out << v.transpose() << "\n";
  for (const Eigen::Vector3i& t : mesh.triangles)
    if (faces) out << "3 " << t.transpose() << "\n";
  return out.str();
}

std::string plyBinary(const Mesh& mesh) {
  std::string file =
      "ply\nformat binary_little_endian 1.0\nelement vertex 8\nproperty float x\nproperty float "
      "y\nproperty double z\nelement face 12\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vec3& v : mesh.vertices)
    add(file, float(v.x())), add(file, float(v.y())), add(file, v.z());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    add(file, std::uint8_t{3});
    for (int k = 0; k < 3; ++k) add(file, t[k]);
  }
  return file;
}

std::vector<std::string> meshSeeds() {
  const Mesh mesh = cube(10);
  return {withFormat(0, stlText(mesh)), withFormat(0, stlBinary(mesh)),
          withFormat(1, plyText(mesh, true)), withFormat(1, plyBinary(mesh))};
}

std::vector<std::string> pointSeeds() {
  std::string grid =
      "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 4\nHEIGHT 4\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 16\nDATA ";
  std::string text = grid + "ascii\n", bytes = grid + "binary\n", rows;
  for (int k = 0; k < 16; ++k) {
    const float x = float(k % 4), y = float(k / 4);
    text += std::to_string(x) + " " + std::to_string(y) + " 9\n";
    rows += std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(k % 3) + "\n";
    add(bytes, x), add(bytes, y), add(bytes, 9.0f);
  }
  const std::string flat =
      "FIELDS x y z normal_x normal_y normal_z\nSIZE 4 4 4 4 4 4\nTYPE F F F F F F\n"
      "WIDTH 2\nHEIGHT 1\nDATA ascii\n1 2 3 0 0 1\n4 5 6 0 1 0\n";
  return {withFormat(0, plyText(cube(10), false)),
          withFormat(1, text),
          withFormat(1, bytes),
          withFormat(1, flat),
          withFormat(2, rows),
          withFormat(2, "1 2 3 0 0 1 # a\n4,5,6,0,1,0\n")};
}

std::string volumeValues() {
  std::string values;
  for (int k = 0; k < 6 * 5 * 4; ++k)
    add(values, static_cast<std::int16_t>(k % 7 == 3 ? 200 : k % 3));
  return values;
}

std::vector<std::string> volumeSeeds() {
  const std::string nrrd =
      "NRRD0004\ntype: short\ndimension: 3\nsizes: 6 5 4\nspacings: 1 1 2\n"
      "space units: \"mm\" \"mm\" \"mm\"\nendian: little\n";
  const std::string meta =
      "ObjectType = Image\nNDims = 3\nDimSize = 6 5 4\nElementType = MET_SHORT\n"
      "ElementSpacing = 1 1 2\nOffset = 0 0 1\nBinaryData = True\n"
      "BinaryDataByteOrderMSB = False\nElementDataFile = LOCAL\n";
  // 120 zeros of two bytes by gzip.
  const unsigned char zipped[] = {0x1f, 0x8b, 8, 0, 0,    0,    0,    0,    2,    3, 0x63, 0x60,
                                  0x18, 0x1e, 0, 0, 0x3e, 0x77, 0x17, 0x5a, 0xf0, 0, 0,    0};
  const std::string packed(reinterpret_cast<const char*>(zipped), sizeof zipped);
  return {
      withFormat(0, nrrd + "encoding: raw\n\n" + volumeValues()),
      withFormat(0, nrrd + "encoding: gzip\n\n" + packed),
      withFormat(0,
                 "NRRD0004\ntype: float\ndimension: 3\nsizes: 2 2 2\nspace: LPS\nspace directions: "
                 "(1,0,0) (0,-1,0) (0,0,1)\nspace origin: (0,0,0)\nendian: big\nencoding: raw\n\n" +
                     std::string(32, '?')),
      withFormat(1, meta + volumeValues())};
}

}  // namespace

Target meshTarget() {
  return {"mesh", readMesh, meshSeeds, 4096};
}
Target pointsTarget() {
  return {"points", readPoints, pointSeeds, 4096};
}
Target volumeTarget() {
  return {"volume", readVolume, volumeSeeds, 4096};
}

}  // namespace cloudcontact::fuzz
