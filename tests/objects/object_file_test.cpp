// Every kind of object is read back unchanged, and damaged files are refused.
#include <cloudcontact/objects/object_file.h>
#include <cloudcontact/voxels/cloud_file.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "objects/test_objects.h"

namespace cloudcontact::object_file_test {
namespace {

namespace fs = std::filesystem;
using namespace test;

DepthImage smallImage() {
  DepthImage image;
  image.width = 5, image.height = 4;
  image.viewpoint = Vec3(0, 0, -1);
  for (int k = 0; k < 20; ++k) image.points.push_back(Vec3(k % 5, k / 5, 2));
  image.points[7].setConstant(NAN);
  return image;
}

std::vector<DigitalObject> objects() {
  const Cloud ball = ballCloud(4), both = twoMaterials();
  return {ball,
          both,
          centerPoints(both, 2),
          surfacePoints(ball),
          inscribedSpheres(both),
          toColumns(both, 1, 3),
          Octree(both),
          Octree(ball),
          SphereTree(inscribedSpheres(ball)),
          SphereTree(both),
          smallImage()};
}

void expectSame(const Cloud& a, const Cloud& b) {
  EXPECT_EQ(a.origin(), b.origin());
  expectSameVoxels(a, b);
}
void expectSame(const PointCloud& a, const PointCloud& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.spacing, b.spacing);
  EXPECT_EQ(a.shares, b.shares);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(a.material, b.material);
  EXPECT_EQ(a.materials, b.materials);
}
void expectSame(const SphereCloud& a, const SphereCloud& b) {
  EXPECT_EQ(a.centers, b.centers);
  EXPECT_EQ(a.radii, b.radii);
  EXPECT_EQ(a.material, b.material);
  EXPECT_EQ(a.materials, b.materials);
}
void expectSame(const ColumnCloud& a, const ColumnCloud& b) {
  EXPECT_EQ(a.axis, b.axis);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_EQ(a.columns, b.columns);
  EXPECT_EQ(a.first, b.first);
  EXPECT_EQ(a.materials, b.materials);
  ASSERT_EQ(a.intervals.size(), b.intervals.size());
  for (std::size_t i = 0; i < a.intervals.size(); ++i) {
    ASSERT_EQ(a.intervals[i].low, b.intervals[i].low);
    ASSERT_EQ(a.intervals[i].high, b.intervals[i].high);
    ASSERT_EQ(a.intervals[i].share, b.intervals[i].share);
    ASSERT_EQ(a.intervals[i].material, b.intervals[i].material);
  }
}
void expectSame(const Octree& a, const Octree& b) {
  EXPECT_TRUE(a == b);
}
void expectSame(const SphereTree& a, const SphereTree& b) {
  EXPECT_EQ(a.kind(), b.kind());
  EXPECT_EQ(a.materials(), b.materials());
  ASSERT_EQ(a.nodes().size(), b.nodes().size());
  for (std::size_t i = 0; i < a.nodes().size(); ++i) {
    ASSERT_EQ(a.nodes()[i].center, b.nodes()[i].center);
    ASSERT_EQ(a.nodes()[i].radius, b.nodes()[i].radius);
    ASSERT_EQ(a.nodes()[i].second, b.nodes()[i].second);
  }
  for (std::size_t i = 0; i < a.leaves().size(); ++i) {
    ASSERT_EQ(a.leaves()[i].center, b.leaves()[i].center);
    ASSERT_EQ(a.leaves()[i].share, b.leaves()[i].share);
    ASSERT_EQ(a.leaves()[i].material, b.leaves()[i].material);
    ASSERT_EQ(a.leaves()[i].item, b.leaves()[i].item);
  }
}
void expectSame(const DepthImage& a, const DepthImage& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.viewpoint, b.viewpoint);
  ASSERT_EQ(a.points.size(), b.points.size());
  EXPECT_EQ(std::memcmp(a.points.data(), b.points.data(), a.points.size() * sizeof(Vec3)), 0);
}

class ObjectFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("cloudcontact_object_file_" +
               std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) +
               std::to_string(reinterpret_cast<std::uintptr_t>(this)));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string savedBytes(const DigitalObject& object) {
    saveObject(object, folder_ / "a.cloud");
    std::ifstream in(folder_ / "a.cloud", std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  fs::path written(const std::string& bytes) {
    std::ofstream(folder_ / "b.cloud", std::ios::binary) << bytes;
    return folder_ / "b.cloud";
  }
  void expectRefused(const std::string& bytes, const std::string& why) {
    const fs::path file = written(bytes);
    try {
      loadObject(file);
      ADD_FAILURE() << "accepted: " << why;
    } catch (const std::runtime_error& e) {
      const std::string message = e.what();
      EXPECT_NE(message.find(file.string()), std::string::npos) << message;
      EXPECT_NE(message.find(why), std::string::npos) << message;
    }
  }
  fs::path folder_;
};

TEST_F(ObjectFile, EveryKindIsReadBack) {
  for (const DigitalObject& object : objects()) {
    SCOPED_TRACE(kindName(object));
    saveObject(object, folder_ / "a.cloud");
    const DigitalObject back = loadObject(folder_ / "a.cloud");
    ASSERT_EQ(back.index(), object.index());
    std::visit([&](const auto& o) { expectSame(o, std::get<std::decay_t<decltype(o)>>(back)); },
               object);
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(ObjectFile, VoxelsEqualTheFilesOfSaveCloud) {
  const Cloud cloud = twoMaterials();
  const std::string bytes = savedBytes(cloud);
  saveCloud(cloud, folder_ / "c.cloud");
  std::ifstream in(folder_ / "c.cloud", std::ios::binary);
  EXPECT_EQ(bytes, std::string(std::istreambuf_iterator<char>(in), {}));
  EXPECT_EQ(bytes[8], 2);
  EXPECT_EQ(savedBytes(ballCloud(4))[8], 1);
  expectSame(loadCloud(folder_ / "c.cloud"), cloud);
}

TEST_F(ObjectFile, LoadCloudRefusesOtherKinds) {
  for (const DigitalObject& object : objects()) {
    if (std::holds_alternative<Cloud>(object)) continue;
    saveObject(object, folder_ / "a.cloud");
    try {
      loadCloud(folder_ / "a.cloud");
      ADD_FAILURE() << kindName(object);
    } catch (const std::runtime_error& e) {
      EXPECT_NE(std::string(e.what()).find("another kind of object"), std::string::npos);
    }
  }
}

TEST_F(ObjectFile, DamageIsRefused) {
  for (const DigitalObject& object : objects()) {
    SCOPED_TRACE(kindName(object));
    const std::string bytes = savedBytes(object);
    const std::size_t step = bytes.size() / 60 + 1;
    for (std::size_t n = 0; n < bytes.size(); n += n < 60 ? 7 : step)
      expectRefused(bytes.substr(0, n), "");
    expectRefused(bytes.substr(0, bytes.size() - 1), "cut short");
    expectRefused(bytes + "x", "1 bytes too many");
    for (std::size_t n = 0; n < bytes.size(); n += n < 60 ? 1 : step)
      for (const char flip : {'\x01', '\x80'}) {
        std::string damaged = bytes;
        damaged[n] = static_cast<char>(damaged[n] ^ flip);
        expectRefused(damaged, "");
      }
  }
}

// A list longer than the file is refused, even if the checksum matches.
TEST_F(ObjectFile, ImpossibleSizesAreRefusedBeforeAnyAllocation) {
  std::string bytes = savedBytes(surfacePoints(ballCloud(4)));
  for (std::size_t k = 0; k < 8; ++k) bytes[24 + k] = k < 6 ? '\xff' : '\0';  // number of positions
  expectRefused(bytes, "impossible sizes");
  std::string kind = savedBytes(smallImage());
  kind[12] = 77;
  expectRefused(kind, "");
}

TEST_F(ObjectFile, InvalidObjectsAreNotWritten) {
  PointCloud nan;
  nan.positions.assign(3, Vec3(0, NAN, 0));
  SphereCloud flat;
  flat.centers.assign(1, Vec3(0, 0, 0)), flat.radii.assign(1, 0);
  const std::vector<DigitalObject> bad = {Cloud(),  PointCloud(),  nan,
                                          flat,     SphereCloud(), ColumnCloud(),
                                          Octree(), SphereTree(),  DepthImage()};
  for (const DigitalObject& object : bad)
    EXPECT_THROW(saveObject(object, folder_ / "bad.cloud"), std::runtime_error) << kindName(object);
  EXPECT_TRUE(fs::is_empty(folder_));
}

}  // namespace
}  // namespace cloudcontact::object_file_test
