// Field files: fields are read back to the bit, and damaged files are refused.
#include <cloudcontact/field/field_file.h>
#include <cloudcontact/voxels/digitize.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>

#include "field/field_data.h"
#include "mesh/test_meshes.h"
#include "workpiece/cut_cases.h"

namespace cloudcontact::field_file_test {
namespace {

namespace fs = std::filesystem;

FieldSettings settings() {
  FieldSettings s;
  s.threads = 1;
  return s;
}

Cloud digitized(const std::vector<NamedMesh>& meshes) {
  DigitizeSettings how;
  how.voxelSize = 0.07;
  how.threads = 1;
  return digitize(meshes, how);
}

// A ball with a smaller one of another material in it.
Cloud twoMaterials() {
  return digitized({{"shell", test::moved(test::sphereMesh(0.6, 3), test::oddTurn(), {3, -2, 1})},
                    {"core", test::moved(test::sphereMesh(0.3, 3), test::oddTurn(), {3, -2, 1})}});
}

class FieldFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ =
        fs::temp_directory_path() / ("cloudcontact_field_file_" + std::string(info->name()) + "_" +
                                     std::to_string(reinterpret_cast<std::uintptr_t>(this)));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  // A box, turned, so that it has edges.
  static std::shared_ptr<const SurfaceField> sample() {
    return SurfaceField::build(
        digitized({{"", test::moved(test::boxMesh({-0.4, -0.3, -0.5}, {0.4, 0.3, 0.5}),
                                    test::oddTurn(), {3, -2, 1})}}),
        settings());
  }
  std::string savedBytes() {
    saveField(*sample(), folder_ / "sample.field");
    std::ifstream in(folder_ / "sample.field", std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  fs::path written(const std::string& bytes) {
    const fs::path file = folder_ / "written.field";
    std::ofstream(file, std::ios::binary) << bytes;
    return file;
  }
  void expectRefused(const fs::path& file, const std::string& why) {
    try {
      loadField(file);
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

void expectSame(const SurfaceField& back, const SurfaceField& field) {
  EXPECT_EQ(back.hash(), field.hash());
  EXPECT_EQ(back.bandVoxels(), field.bandVoxels());
  EXPECT_EQ(back.sampleCount(), field.sampleCount());
  EXPECT_EQ(back.bounds().min(), field.bounds().min());
  EXPECT_EQ(back.bounds().max(), field.bounds().max());
  const Cloud &a = back.cloud(), &b = field.cloud();
  EXPECT_EQ(a.voxelSize(), b.voxelSize());
  EXPECT_EQ(a.origin(), b.origin());
  EXPECT_EQ(a.bricks(), b.bricks());
  EXPECT_EQ(a.voxels().table, b.voxels().table);
  EXPECT_EQ(a.voxels().coverage, b.voxels().coverage);
  EXPECT_EQ(a.voxels().materials, b.voxels().materials);
  EXPECT_EQ(a.voxels().materialTable, b.voxels().materialTable);
  EXPECT_EQ(a.voxels().material, b.voxels().material);
  for (std::size_t k = 0; k < field.sampleCount(); k += 7) {
    const SurfaceSample s = field.sample(k);
    const Vec3 at = b.origin() + b.voxelSize() * Vec3(s.position[0], s.position[1], s.position[2]);
    const auto p = back.at(at), q = field.at(at);
    ASSERT_TRUE(p && q);
    EXPECT_EQ(p->depth, q->depth);
    EXPECT_EQ(p->normal, q->normal);
  }
}

TEST_F(FieldFile, IsReadBackToTheBit) {
  const auto one = sample(), two = SurfaceField::build(twoMaterials(), settings());
  ASSERT_EQ(two->cloud().voxels().materials.size(), 2u);
  for (const auto& field : {one, two}) {
    saveField(*field, folder_ / "a.field");
    expectSame(*loadField(folder_ / "a.field"), *field);
    EXPECT_EQ(filesInFolder(), 1u);
  }
}

// What is loaded cannot be renewed in part, but all the same becomes the field of the cut cloud.
TEST_F(FieldFile, IsRenewed) {
  FieldSettings renewable = settings();
  renewable.renewable = true;
  const auto field = SurfaceField::build(sample()->cloud(), renewable);
  saveField(*field, folder_ / "a.field");
  const auto back = loadField(folder_ / "a.field");
  EXPECT_LT(back->bytes(), field->bytes());
  const Vec3 middle = 0.5 * field->cloud().size().cast<double>();
  const Cloud cut = cutCloud(field->cloud(), testing::bite(field->cloud(), middle, 6));
  EXPECT_EQ(renewed(back, cut, settings())->hash(), SurfaceField::build(cut, settings())->hash());
}

TEST_F(FieldFile, RefusesWhatIsNotSettled) {
  FieldSettings renewable = settings();
  renewable.renewable = true;
  const auto field = SurfaceField::build(sample()->cloud(), renewable);
  const SurfaceSample s = field->sample(0);
  const Cloud cut =
      cutCloud(field->cloud(),
               testing::bite(field->cloud(), Vec3(s.position[0], s.position[1], s.position[2]), 3));
  renewable.edgeSearches = 0;
  const auto blunt = renewed(field, cut, renewable);
  ASSERT_GT(blunt->unsettled(), 0u);
  EXPECT_THROW(saveField(*blunt, folder_ / "a.field"), std::runtime_error);
  EXPECT_EQ(filesInFolder(), 0u);
}

TEST_F(FieldFile, TruncatedAnywhereIsRefused) {
  const std::string bytes = savedBytes();
  for (std::size_t length = 0; length < bytes.size(); length += length < 100 ? 1 : 19777)
    expectRefused(written(bytes.substr(0, length)), "cut short");
  expectRefused(written(bytes.substr(0, bytes.size() - 1)), "cut short");
  expectRefused(written(bytes + "x"), "1 bytes too many");
}

// A file with any wrong byte is refused: sizes by the length, the rest by the checksum.
TEST_F(FieldFile, AnyWrongByteIsRefused) {
  const std::string bytes = savedBytes();
  for (std::size_t i = 0; i < bytes.size(); i += i < 120 ? 1 : 20011)
    for (const char flip : {'\x01', '\x80'}) {
      std::string damaged = bytes;
      damaged[i] = static_cast<char>(damaged[i] ^ flip);
      expectRefused(written(damaged), "");
    }
}

TEST_F(FieldFile, NamesTheFault) {
  const std::string bytes = savedBytes();
  expectRefused(folder_ / "none.field", "no such file");
  expectRefused(folder_, "is not a file");
  expectRefused(written("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "is not a surface field");
  std::string later = bytes;
  later[8] = 9;
  expectRefused(written(later), "is a field of version 9");
  std::string huge = bytes;
  for (std::size_t i = 72; i < 80; ++i) huge[i] = '\x7f';  // length of the names
  expectRefused(written(huge), "impossible sizes");
  std::string damaged = bytes;
  damaged[bytes.size() - 100] ^= 1;
  expectRefused(written(damaged), "checksum does not match");
}

// A right checksum does not make a field: what a search would follow out of its arrays, or could
// not compute with, is refused.
TEST_F(FieldFile, RefusesWhatDoesNotFitTogether) {
  const auto good = sample();
  const auto refuses = [&](const std::function<void(FieldRecords&, SampleSet&)>& change) {
    FieldRecords records = good->data().records();
    SampleSet samples = good->data().samples();
    change(records, samples);
    saveField(SurfaceField(std::make_shared<const FieldData>(good->cloud(), std::move(records),
                                                             std::move(samples))),
              folder_ / "changed.field");
    expectRefused(folder_ / "changed.field", "impossible sizes");
  };
  const auto last = [](auto& list) -> auto& {
    return list.back();
  };
  refuses([&](FieldRecords&, SampleSet& s) { last(s.levels[1].finer).count += 1; });
  refuses([&](FieldRecords&, SampleSet& s) { s.levels[2].finer[0].first = 1; });
  refuses([&](FieldRecords&, SampleSet& s) { last(s.levels[1].cellOf) = 0x7fffffff; });
  refuses([&](FieldRecords&, SampleSet& s) { last(s.levels[2].cellOf) = 0; });
  refuses([&](FieldRecords&, SampleSet& s) { last(s.bricks.runs).count = 0xffffffff; });
  refuses([&](FieldRecords&, SampleSet& s) { s.levels[0].samples.nx.pop_back(); });
  refuses([&](FieldRecords&, SampleSet& s) { s.levels[1].clusters.spread[3].pop_back(); });
  for (const float wrong : {std::numeric_limits<float>::quiet_NaN(), 1e30f}) {
    refuses([&](FieldRecords&, SampleSet& s) { s.levels[0].samples.y[3] = wrong; });
    refuses([&](FieldRecords&, SampleSet& s) { s.levels[2].samples.area[0] = wrong; });
    refuses([&](FieldRecords&, SampleSet& s) { s.bricks.radius[0] = wrong; });
  }
  refuses([&](FieldRecords& r, SampleSet&) {
    int at = 0;
    const auto far = [&](auto& array) {
      if constexpr (std::is_same_v<decltype(array[0]), CcVoxel&>)
        if (at++ == 0)  // the records
          for (CcVoxel& v : array)
            if (ccPlaneCount(v) > 1) v.b = 0x7fffffff;
    };
    FieldRecords::forEachArray(r, far);
  });
}

TEST_F(FieldFile, LeavesNoPartialFile) {
  EXPECT_THROW(saveField(*sample(), folder_ / "no" / "such" / "a.field"), std::runtime_error);
  EXPECT_THROW(saveField(*sample(), folder_), std::runtime_error);
  EXPECT_EQ(filesInFolder(), 0u);
}

}  // namespace
}  // namespace cloudcontact::field_file_test
