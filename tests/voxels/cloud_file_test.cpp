// Cloud files: clouds are read back to the bit, and damaged files are refused.
#include <cloudcontact/voxels/cloud_file.h>
#include <cloudcontact/voxels/digitize.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "mesh/test_meshes.h"

namespace cloudcontact::cloud_file_test {
namespace {

namespace fs = std::filesystem;

class CloudFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("cloudcontact_cloud_file_" + std::string(info->name()) + "_" +
               std::to_string(::testing::UnitTest::GetInstance()->random_seed()) + "_" +
               std::to_string(reinterpret_cast<std::uintptr_t>(this)));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  static Cloud sample() {
    DigitizeSettings settings;
    settings.voxelSize = 0.07;
    return digitize(test::moved(test::sphereMesh(0.5, 3), test::oddTurn(), {3, -2, 1}), settings);
  }
  std::string savedBytes() {
    saveCloud(sample(), folder_ / "sample.cloud");
    std::ifstream in(folder_ / "sample.cloud", std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  fs::path written(const std::string& bytes) {
    const fs::path file = folder_ / "written.cloud";
    std::ofstream(file, std::ios::binary) << bytes;
    return file;
  }
  void expectRefused(const fs::path& file, const std::string& why) {
    try {
      loadCloud(file);
      ADD_FAILURE() << "accepted: " << why;
    } catch (const std::runtime_error& e) {
      const std::string message = e.what();
      EXPECT_NE(message.find(file.string()), std::string::npos) << message;
      EXPECT_NE(message.find(why), std::string::npos) << message;
    }
  }
  std::size_t filesInFolder() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  fs::path folder_;
};

TEST_F(CloudFile, IsReadBackToTheBit) {
  const Cloud cloud = sample();
  saveCloud(cloud, folder_ / "a.cloud");
  const Cloud back = loadCloud(folder_ / "a.cloud");
  EXPECT_EQ(back.voxelSize(), cloud.voxelSize());
  EXPECT_EQ(back.origin(), cloud.origin());
  EXPECT_EQ(back.bricks(), cloud.bricks());
  EXPECT_EQ(back.voxels().table, cloud.voxels().table);
  EXPECT_EQ(back.voxels().coverage, cloud.voxels().coverage);
  EXPECT_EQ(filesInFolder(), 1u);
}

TEST_F(CloudFile, ReplacesAnOldOne) {
  const fs::path file = written("something else");
  saveCloud(sample(), file);
  EXPECT_EQ(loadCloud(file).bricks(), sample().bricks());
  EXPECT_EQ(filesInFolder(), 1u);
}

TEST_F(CloudFile, TruncatedAnywhereIsRefused) {
  const std::string bytes = savedBytes();
  for (std::size_t length = 0; length < bytes.size(); length += length < 200 ? 1 : 977)
    expectRefused(written(bytes.substr(0, length)), length == 0 ? "cut short" : "");
  expectRefused(written(bytes.substr(0, bytes.size() - 1)), "cut short");
  expectRefused(written(bytes + "x"), "1 bytes too many");
}

// A file with any wrong byte is refused: sizes by the length, the rest by the checksum.
TEST_F(CloudFile, AnyWrongByteIsRefused) {
  const std::string bytes = savedBytes();
  for (std::size_t i = 0; i < bytes.size(); i += i < 200 ? 1 : 1009)
    for (const char flip : {'\x01', '\x80'}) {
      std::string damaged = bytes;
      damaged[i] = static_cast<char>(damaged[i] ^ flip);
      expectRefused(written(damaged), "");
    }
}

TEST_F(CloudFile, NamesTheFault) {
  const std::string bytes = savedBytes();
  expectRefused(folder_ / "none.cloud", "no such file");
  expectRefused(folder_, "is not a file");
  expectRefused(written("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "is not a cloud");
  std::string later = bytes;
  later[8] = 9;
  expectRefused(written(later), "is a cloud of version 9");
  std::string huge = bytes;
  for (int i = 44; i < 56; ++i) huge[i] = '\x7f';
  expectRefused(written(huge), "impossible sizes");
}

TEST_F(CloudFile, LeavesNoPartialFile) {
  EXPECT_THROW(saveCloud(sample(), folder_ / "no" / "such" / "a.cloud"), std::runtime_error);
  EXPECT_THROW(saveCloud(sample(), folder_), std::runtime_error);
  EXPECT_THROW(saveCloud(Cloud(), folder_ / "a.cloud"), std::runtime_error);
  EXPECT_EQ(filesInFolder(), 0u);
}

}  // namespace
}  // namespace cloudcontact::cloud_file_test
