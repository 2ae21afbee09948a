// Point files: every supported format, and a table of broken files.
#include <cloudcontact/objects/point_file.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace cloudcontact::point_file_test {
namespace {

namespace fs = std::filesystem;

template <typename Number>
std::string raw(Number x, bool big = false) {
  static_assert(std::endian::native == std::endian::little);
  std::string bytes(sizeof(x), '\0');
  std::memcpy(bytes.data(), &x, sizeof(x));
  return big ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

const std::vector<Vec3> kPoints = {{0, 0, 0}, {1.5, -2, 0.25}, {3, 4, -5}, {0.5, 0.5, 0.5}};

std::string text(const std::string& tail = "") {
  std::ostringstream out;
  for (const Vec3& p : kPoints) out << p.transpose() << tail << '\n';
  return out.str();
}

std::string plyHeader(const std::string& format, const std::string& more = "") {
  return "ply\nformat " + format + " 1.0\ncomment a test\nelement vertex " +
         std::to_string(kPoints.size()) +
         "\nproperty float x\nproperty float y\nproperty float z\n" + more + "end_header\n";
}

std::string pcd(const std::string& data, int width, int height, const std::string& body) {
  return "# .PCD v.7 - a test\nVERSION .7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\n"
         "COUNT 1 1 1 1\nWIDTH " +
         std::to_string(width) + "\nHEIGHT " + std::to_string(height) +
         "\nVIEWPOINT 0 0 -2 1 0 0 0\nPOINTS " + std::to_string(width * height) + "\nDATA " + data +
         "\n" + body;
}

std::string binaryBody() {
  std::string bytes;
  for (const Vec3& p : kPoints) {
    for (int k = 0; k < 3; ++k) bytes += raw(static_cast<float>(p[k]));
    bytes += raw(std::uint32_t{0xffffff});
  }
  return bytes;
}

class PointFileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("cloudcontact_point_file_" +
               std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) +
               std::to_string(reinterpret_cast<std::uintptr_t>(this)));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path written(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  void expectPoints(const std::string& name, const std::string& bytes, bool normals = false) {
    SCOPED_TRACE(name);
    const fs::path file = written(name, bytes);
    EXPECT_TRUE(isPointFile(file));
    const PointFile read = loadPoints(file, 1e-3);
    ASSERT_TRUE(std::holds_alternative<PointCloud>(read));
    const PointCloud& points = std::get<PointCloud>(read);
    ASSERT_EQ(points.positions.size(), kPoints.size());
    for (std::size_t i = 0; i < kPoints.size(); ++i)
      EXPECT_LT((points.positions[i] - 1e-3 * kPoints[i]).norm(), 1e-9);
    ASSERT_EQ(points.normals.size(), normals ? kPoints.size() : 0u);
    if (normals) {
      EXPECT_LT((points.normals[0] - Eigen::Vector3f(0.6f, 0, -0.8f)).norm(), 1e-6f);
    }
    EXPECT_EQ(points.spacing, 0);
  }
  void expectRefused(const std::string& name, const std::string& bytes, const std::string& why) {
    const fs::path file = written(name, bytes);
    try {
      loadPoints(file);
      ADD_FAILURE() << "accepted: " << why;
    } catch (const std::runtime_error& e) {
      const std::string message = e.what();
      EXPECT_NE(message.find(file.string()), std::string::npos) << message;
      EXPECT_NE(message.find(why), std::string::npos) << message;
    }
  }
  fs::path folder_;
};

TEST_F(PointFileTest, EveryFormatIsRead) {
  const std::string normals = "property float nx\nproperty float ny\nproperty float nz\n";
  expectPoints("a.ply", plyHeader("ascii") + text());
  expectPoints("b.ply", plyHeader("ascii", normals) + text(" 0.6 0 -0.8"), true);
  expectPoints("c.ply", plyHeader("ascii", "property uchar red\n") + text(" 200"));
  for (const bool big : {false, true}) {
    std::string body;
    for (const Vec3& p : kPoints)
      for (int k = 0; k < 3; ++k) body += raw(static_cast<float>(p[k]), big);
    expectPoints(big ? "d.ply" : "e.ply",
                 plyHeader(big ? "binary_big_endian" : "binary_little_endian") + body);
  }
  expectPoints("a.pcd", pcd("ascii", 4, 1, text(" 7")));
  expectPoints("b.pcd", pcd("binary", 4, 1, binaryBody()));
  expectPoints("c.pcd",
               "VERSION .7\nFIELDS normal_x x y z normal_y normal_z\nSIZE 8 8 8 8 8 8\n"
               "TYPE F F F F F F\nWIDTH 4\nHEIGHT 1\nDATA ascii\n"
               ".6 0 0 0 0 -.8\n.6 1.5 -2 0.25 0 -.8\n.6 3 4 -5 0 -.8\n.6 .5 .5 .5 0 -.8\n",
               true);
  expectPoints("a.xyz", text());
  expectPoints("b.xyz", "# made by hand\n\n" + text(" 0.6 0 -0.8"), true);
  expectPoints("c.XYZ", text(" 200 100 50"));  // colors
  expectPoints("d.xyz", text(" 17"));          // intensity
  expectPoints("e.xyz", "0,0,0\n1.5;-2;0.25\r\n3\t4 -5\n0.5 0.5 0.5");
}

TEST_F(PointFileTest, OrganizedPcdIsADepthImage) {
  std::string body = "0 0 nan 0\n" + text(" 0");
  body = body.substr(0, body.rfind("0.5 0.5 0.5")) + "0 0 -2 0\n1 1 1 0\n";
  const PointFile read = loadPoints(written("a.pcd", pcd("ascii", 3, 2, body)), 1e-3);
  ASSERT_TRUE(std::holds_alternative<DepthImage>(read));
  const DepthImage& image = std::get<DepthImage>(read);
  EXPECT_EQ(image.width, 3);
  EXPECT_EQ(image.height, 2);
  EXPECT_LT((image.viewpoint - Vec3(0, 0, -2e-3)).norm(), 1e-12);
  EXPECT_TRUE(image.points[0].array().isNaN().all());
  EXPECT_LT((image.points[2] - 1e-3 * kPoints[1]).norm(), 1e-9);
  EXPECT_TRUE(image.points[4].array().isNaN().all()) << "the viewpoint is not a point";
}

TEST_F(PointFileTest, BrokenFilesAreRefused) {
  const std::string point = "0 0 0\n";
  expectRefused("a.ply", "", "is empty");
  expectRefused("a.pcd", "", "is empty");
  expectRefused("a.xyz", "", "is empty");
  expectRefused("a.xyz", "# nothing\n\n", "has no points");
  expectRefused("a.ply", "points\n", "is no PLY");
  expectRefused("a.ply", plyHeader("ascii"), "cut short");
  expectRefused("a.ply", plyHeader("ascii") + point, "cut short");
  expectRefused("a.ply", plyHeader("binary_little_endian") + "abc", "cut short");
  expectRefused("a.ply", plyHeader("morse") + point, "without a known format");
  expectRefused("a.ply", plyHeader("ascii") + "0 0 0\n1 1 1\n1 nan 1\n1 1 1\n", "point 2 is NaN");
  expectRefused("a.ply", plyHeader("ascii") + "0 0 0\n1 1 1\n1 one 1\n1 1 1\n", "point 2 is NaN");
  expectRefused("a.ply", plyHeader("ascii") + "0 0 0\n1 inf 1\n1 1 1\n1 1 1\n", "point 1 is NaN");
  expectRefused("a.ply",
                "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nend_header\n1\n2\n",
                "without x, y and z");
  expectRefused("a.ply",
                "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n"
                "property float z\nend_header\n",
                "has no points");
  expectRefused("a.ply",
                "ply\nformat ascii 1.0\nelement vertex 18446744073709551615\nproperty float x\n"
                "property float y\nproperty float z\nend_header\n1 2 3\n",
                "cut short");
  expectRefused("a.pcd", "these are words\n", "its header has no DATA");
  expectRefused("a.pcd", pcd("binary_compressed", 4, 1, binaryBody()), "compressed");
  expectRefused("a.pcd", pcd("morse", 4, 1, binaryBody()), "no known kind");
  expectRefused("a.pcd", pcd("binary", 4, 1, binaryBody().substr(0, 50)), "cut short");
  expectRefused("a.pcd", pcd("ascii", 5, 1, text(" 0")), "cut short");
  expectRefused("a.pcd", pcd("ascii", 2000000000, 1, text(" 0")), "");
  expectRefused("a.pcd", pcd("ascii", 0, 1, ""), "no points");
  // 2,000 fields of a million numbers each: 16 GB, were they made room for.
  std::string many = "FIELDS x y z", counts = "COUNT 1 1 1";
  for (int i = 0; i < 2000; ++i) many += " f", counts += " 1048576";
  for (const char* const kind : {"ascii", "binary"})
    expectRefused(
        "a.pcd", many + "\n" + counts + "\nWIDTH 1\nHEIGHT 1\nDATA " + kind + "\n1 2 3 4 5 6 7 8\n",
        "cut short");
  expectRefused("a.pcd", pcd("ascii", -4, 1, text(" 0")), "");
  expectRefused("a.pcd", pcd("ascii", 4, 1, "nan 0 0 0\n" + text(" 0")), "point 0 is NaN");
  expectRefused("a.pcd", pcd("ascii", 2, 2, "nan 0 0 0\nnan 1 1 1\nnan 1 2 3\nnan 2 2 2\n"),
                "fewer than three");
  expectRefused("a.pcd", "FIELDS x y\nSIZE 4 4\nTYPE F F\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1 2\n",
                "no fields x, y and z");
  expectRefused("a.pcd", "FIELDS x y z\nSIZE 4 3 4\nDATA ascii\n", "bad line");
  expectRefused("a.pcd", "FIELDS x y z\nSIZE 4 4 4\nTYPE F F Q\nDATA ascii\n", "bad line");
  expectRefused("a.pcd", "FIELDS x y z\nSIZE 4 4\nDATA ascii\n", "bad line");
  expectRefused("a.xyz", "1 2 3\n1 2\n", "row 2");
  expectRefused("a.xyz", "1 2 3\n1 two 3\n", "`two`");
  expectRefused("a.xyz", "1 2 3\n1 nan 3\n", "point 1 is NaN");
  expectRefused("a.xyz", "1 2 3\n1e999 2 3\n", "point 1 is NaN");
  expectRefused("a.foo", "1 2 3\n", "no known format");
  EXPECT_THROW(loadPoints(folder_ / "none.ply"), std::runtime_error);
  EXPECT_THROW(loadPoints(folder_), std::runtime_error);
  EXPECT_THROW(loadPoints(written("a.xyz", text()), 0), std::runtime_error);
  EXPECT_THROW(loadPoints(written("a.xyz", text()), NAN), std::runtime_error);
}

TEST_F(PointFileTest, MeshesAreNotPoints) {
  EXPECT_FALSE(isPointFile(written("a.ply",
                                   "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                                   "element face 1\nproperty list uchar int vertex_indices\n"
                                   "end_header\n")));
  EXPECT_FALSE(isPointFile(written("a.stl", "solid")));
  EXPECT_FALSE(isPointFile(written("b.ply", "no header")));
  EXPECT_FALSE(isPointFile(folder_ / "none.ply"));
}

}  // namespace
}  // namespace cloudcontact::point_file_test
