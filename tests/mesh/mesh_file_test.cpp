// Mesh files: every supported format, and a table of broken files.
#include <cloudcontact/mesh/mesh_file.h>
#include <cloudcontact/mesh/mesh_repair.h>

#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "mesh/test_meshes.h"

namespace cloudcontact::mesh_file_test {
namespace {

namespace fs = std::filesystem;
using namespace test;

template <typename Number>
std::string raw(Number x) {
  static_assert(std::endian::native == std::endian::little);
  std::string bytes(sizeof(x), '\0');
  std::memcpy(bytes.data(), &x, sizeof(x));
  return bytes;
}

std::string rawVertices(const Mesh& mesh) {
  std::string bytes;
  for (const Vector3d& v : mesh.vertices)
    for (int k = 0; k < 3; ++k) bytes += raw(static_cast<float>(v[k]));
  return bytes;
}

std::string binaryStl(const Mesh& mesh) {
  std::string bytes(80, 'x');
  bytes += raw(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Vector3i& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) bytes += raw(0.0f);
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) bytes += raw(static_cast<float>(mesh.vertices[t[k]][i]));
    bytes += raw(std::uint16_t{0});
  }
  return bytes;
}

std::string asciiStl(const Mesh& mesh) {
  std::ostringstream out;
  out << "solid body of vertices\n";
  for (const Vector3i& t : mesh.triangles) {
    out << "facet normal 0 0 0\nouter loop\n";
    for (int k = 0; k < 3; ++k) out << "vertex " << mesh.vertices[t[k]].transpose() << "\n";
    out << "endloop\nendfacet\n";
  }
  out << "endsolid body\n";
  return out.str();
}

std::string obj(const Mesh& mesh) {
  std::ostringstream out;
  for (const Vector3d& v : mesh.vertices) out << "v " << v.transpose() << "\n";
  for (const Vector3i& t : mesh.triangles)
    out << "f " << (t + Vector3i::Ones()).transpose() << "\n";
  return out.str();
}

std::string plyHeader(const Mesh& mesh, const std::string& format) {
  return "ply\nformat " + format + " 1.0\ncomment made for a test\nelement vertex " +
         std::to_string(mesh.vertices.size()) +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
         std::to_string(mesh.triangles.size()) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

std::string asciiPly(const Mesh& mesh) {
  std::ostringstream out;
  out << plyHeader(mesh, "ascii");
  for (const Vector3d& v : mesh.vertices) out << v.transpose() << "\n";
  for (const Vector3i& t : mesh.triangles) out << "3 " << t.transpose() << "\n";
  return out.str();
}

std::string binaryPly(const Mesh& mesh) {
  std::string bytes = plyHeader(mesh, "binary_little_endian") + rawVertices(mesh);
  for (const Vector3i& t : mesh.triangles) {
    bytes += raw(std::uint8_t{3});
    for (int k = 0; k < 3; ++k) bytes += raw(std::int32_t{t[k]});
  }
  return bytes;
}

std::string base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63];
  }
  return text;
}

// With a node that scales by `scale` and moves to (5, 0, 0).
std::string gltf(const Mesh& mesh, const std::string& scale = "[2,2,2]") {
  std::string bytes = rawVertices(mesh);
  const std::size_t vertexBytes = bytes.size();
  for (const Vector3i& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) bytes += raw(static_cast<std::uint16_t>(t[k]));
  std::ostringstream out;
  out << R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],)"
      << R"("nodes":[{"mesh":0,"scale":)" << scale << R"(,"translation":[5,0,0]}],)"
      << R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
      << R"("buffers":[{"byteLength":)" << bytes.size()
      << R"(,"uri":"data:application/octet-stream;base64,)" << base64(bytes) << R"("}],)"
      << R"("bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":)" << vertexBytes
      << R"(},{"buffer":0,"byteOffset":)" << vertexBytes << R"(,"byteLength":)"
      << bytes.size() - vertexBytes << R"(}],"accessors":[{"bufferView":0,"componentType":5126,)"
      << R"("count":)" << mesh.vertices.size()
      << R"(,"type":"VEC3","min":[-1,-1,-1],"max":[1,1,1]},)"
      << R"({"bufferView":1,"componentType":5123,"count":)" << 3 * mesh.triangles.size()
      << R"(,"type":"SCALAR"}]})";
  return out.str();
}

class MeshFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ =
        fs::temp_directory_path() / ("cloudcontact_mesh_file_" + std::string(info->name()) + "_" +
                                     std::to_string(reinterpret_cast<std::uintptr_t>(this)));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path written(const std::string& name, const std::string& bytes) {
    const fs::path file = folder_ / name;
    std::ofstream(file, std::ios::binary) << bytes;
    return file;
  }
  void expectRefused(const fs::path& file, const std::string& why) {
    try {
      loadMesh(file);
      ADD_FAILURE() << file << " was accepted; expected: " << why;
    } catch (const std::runtime_error& e) {
      const std::string message = e.what();
      EXPECT_EQ(message.find(file.string()), 0u) << message;
      EXPECT_NE(message.find(why), std::string::npos) << message << "; expected: " << why;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      EXPECT_LT(message.size(), 400u) << message;
    }
  }
  fs::path folder_;
};

// Odd numbers that floats hold exactly.
Mesh sample() {
  return tetrahedronMesh({0, 0, 0}, {1, 0, 0}, {0, 0.75, 0}, {0.25, 0.125, 0.5});
}

TEST_F(MeshFile, EveryFormatGivesTheSameBody) {
  const Mesh mesh = sample();
  const std::pair<const char*, std::string> files[] = {
      {"binary.stl", binaryStl(mesh)}, {"ASCII.STL", asciiStl(mesh)},   {"a.obj", obj(mesh)},
      {"ascii.ply", asciiPly(mesh)},   {"binary.ply", binaryPly(mesh)}, {"a.gltf", gltf(mesh)}};
  for (const auto& [name, bytes] : files) {
    SCOPED_TRACE(name);
    const bool scaled = std::string(name) == "a.gltf";
    const Mesh loaded = loadMesh(written(name, bytes));
    EXPECT_EQ(loaded.triangles.size(), 4u);
    const MeshReport report = inspect(loaded);
    EXPECT_TRUE(report.closed());
    EXPECT_NEAR(report.volume, 0.75 * 0.5 / 6 * (scaled ? 8 : 1), 1e-9);
    Vector3d low = loaded.vertices[0];
    for (const Vector3d& v : loaded.vertices) low = low.cwiseMin(v);
    EXPECT_LT((low - Vector3d(scaled ? 5 : 0, 0, 0)).norm(), 1e-6);
  }
}

TEST_F(MeshFile, UnitsAndMirrors) {
  const double truth = 0.75 * 0.5 / 6;
  EXPECT_NEAR(inspect(loadMesh(written("a.stl", binaryStl(sample())), 1e-3)).volume, truth * 1e-9,
              1e-18);
  // A mirrored node keeps the triangles facing outward.
  EXPECT_NEAR(inspect(loadMesh(written("a.gltf", gltf(sample(), "[-1,1,1]")))).volume, truth, 1e-9);
  const fs::path file = written("b.stl", binaryStl(sample()));
  for (const double unit : {0.0, -1.0, std::nan(""), double(INFINITY)})
    EXPECT_THROW(loadMesh(file, unit), std::runtime_error) << unit;
}

TEST_F(MeshFile, PolygonsBecomeTrianglesAndPointsAndLinesAreIgnored) {
  const Mesh mesh =
      loadMesh(written("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nl 1 2\np 3\n"));
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_NEAR(inspect(mesh).area, 1, 1e-9);
}

struct Broken {
  const char* name;
  std::string bytes;
  const char* why;
};

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

std::vector<Broken> brokenStl() {
  Mesh nan = sample();
  nan.vertices[0][0] = NAN;
  const std::string whole = binaryStl(sample()), text = asciiStl(sample());
  std::string lie = whole, none = whole.substr(0, 84);
  lie[83] = '\x40';
  none[80] = 0;
  return {{"empty.stl", "", "is empty"},
          {"cut.stl", whole.substr(0, 150), "says 4 triangles"},
          {"cut_header.stl", whole.substr(0, 60), "at least 84 bytes"},
          {"lie.stl", lie, "but it has 284"},
          {"long.stl", whole + "xx", "but it has 286"},
          {"none.stl", none, "has no triangles"},
          {"nan.stl", binaryStl(nan), "NaN"},
          {"cut_text.stl", text.substr(0, text.size() / 2), "cut short"},
          {"no_end.stl", text.substr(0, text.rfind("endsolid")), "endsolid"},
          {"empty_solid.stl", "solid x\nendsolid x\n", "has no triangles"},
          {"letters.stl", replaced(text, "0.75", "abc"), "`abc` where a number should be"},
          {"prose.stl", "hello, this is not a mesh\n", "no STL"}};
}

std::vector<Broken> brokenPly() {
  const std::string text = asciiPly(sample()), binary = binaryPly(sample());
  const std::size_t data = binary.find("end_header\n") + 11;
  return {{"empty.ply", "", "is empty"},
          {"cut_header.ply", text.substr(0, 60), "end_header"},
          {"cut_text.ply", text.substr(0, text.size() - 5), "cut short"},
          {"cut_binary.ply", binary.substr(0, binary.size() - 5), "cut short"},
          {"cut_vertices.ply", binary.substr(0, data + 20), "cut short"},
          {"no_data.ply", binary.substr(0, data), "cut short"},
          {"index.ply", replaced(text, "3 0 ", "3 77 "), "names vertex 77, but there are 4"},
          {"negative.ply", replaced(text, "3 0 ", "3 -1 "), "names vertex -1"},
          {"format.ply", replaced(text, "ascii", "ebcdic"), "format"},
          {"property.ply", replaced(text, "property float x", "property quux x"), "property"},
          {"element.ply", replaced(text, "element vertex 4", "element vertex"), "element"},
          {"count.ply", replaced(text, "element face 4", "element face 999999999"), "cut short"},
          {"points.ply",
           "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
           "property float z\nend_header\n0 0 0\n",
           "has no triangles"},
          {"no_corners.ply",
           "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
           "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
           "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n0\n",
           "a face without corners"},
          {"prose.ply", "hello, this is not a mesh\n", "is no PLY"}};
}

std::vector<Broken> brokenOthers() {
  const std::string text = gltf(sample());
  return {{"empty.obj", "", "is empty"},
          {"index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "out of range"},
          {"nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "NaN"},
          {"huge.obj", "v 1e60 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "infinite"},
          {"vertices.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "has no triangles"},
          {"lines.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\np 3\n", "has no triangles"},
          {"prose.obj", "hello, this is not a mesh\n", "has no triangles"},
          {"empty.gltf", "", "is empty"},
          {"cut.gltf", text.substr(0, text.size() / 2), "is no mesh"},
          {"missing_bin.gltf",
           replaced(text, text.substr(text.find("data:"), text.find("\"}],") - text.find("data:")),
                    "none.bin"),
           "none.bin"},
          {"beyond.gltf", replaced(text, R"("count":12)", R"("count":1200)"), "is no mesh"},
          {"prose.glb", "hello, this is not a mesh\n", "is no mesh"},
          {"prose.txt", "hello, this is not a mesh\n", "is no mesh"},
          {"without_extension", binaryStl(sample()), "is no mesh"}};
}

TEST_F(MeshFile, BrokenFilesAreRefusedByNameAndReason) {
  for (const auto& table : {brokenStl(), brokenPly(), brokenOthers()})
    for (const Broken& broken : table)
      expectRefused(written(broken.name, broken.bytes), broken.why);
  expectRefused(folder_ / "missing.stl", "no such file");
  fs::create_directories(folder_ / "folder.stl");
  expectRefused(folder_ / "folder.stl", "is not a file");
}

// A file truncated at any length is refused, or still gives the whole body.
TEST_F(MeshFile, TruncatedNeverGivesAnotherBody) {
  const std::pair<const char*, std::string> files[] = {{"a.stl", binaryStl(sample())},
                                                       {"b.stl", asciiStl(sample())},
                                                       {"a.ply", asciiPly(sample())},
                                                       {"b.ply", binaryPly(sample())},
                                                       {"a.gltf", gltf(sample())}};
  for (const auto& [name, bytes] : files)
    for (std::size_t length = 0; length < bytes.size(); length += 3) {
      SCOPED_TRACE(std::string(name) + " cut at " + std::to_string(length));
      try {
        EXPECT_EQ(inspect(loadMesh(written(name, bytes.substr(0, length)))).openEdges, 0u);
      } catch (const std::runtime_error&) {
      }
    }
}

}  // namespace
}  // namespace cloudcontact::mesh_file_test
