// CT volumes from files: a ball in all formats, types and directions of axes, and broken files.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cloudcontact/voxels/volume_file.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <sstream>

namespace cloudcontact::volume_file_test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3i;

constexpr double kRadius = 8e-3;         // [m]
const Vec3 kMiddle(10e-3, 11e-3, 9e-3);  // [m]
constexpr double kAir = -1000, kBone = 1200;

// A ball as a scanner measures it: each value is the mean over its cell.
CtVolume ball(const Vector3i& size, const Vec3& spacing) {
  CtVolume v;
  v.size = size;
  v.spacing = spacing;
  constexpr int n = 8;
  for (int k = 0; k < size.prod(); ++k) {
    const Vec3 corner(k % size.x(), k / size.x() % size.y(), k / size.x() / size.y());
    int in = 0;
    for (int p = 0; p < n * n * n; ++p) {
      const Vec3 part = Vec3(p % n + .5, p / n % n + .5, p / (n * n) + .5) / n;
      in += ((corner + part).cwiseProduct(spacing) - kMiddle).norm() < kRadius;
    }
    v.values.push_back(static_cast<float>(kAir + (kBone - kAir) * in / (n * n * n)));
  }
  return v;
}

CtVolume evenBall() {
  return ball({40, 44, 36}, Vec3::Constant(5e-4));
}

std::string packed(const std::string& bytes, int windowBits) {
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, windowBits, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, bytes.size()) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}
std::string gzipped(const std::string& bytes) {
  return packed(bytes, 15 + 16);
}

template <typename Number>
std::string bytesOf(const CtVolume& v, bool bigEndian = false) {
  std::string out;
  for (const float value : v.values) {
    const auto number = static_cast<Number>(value);
    std::string bytes(reinterpret_cast<const char*>(&number), sizeof(number));
    if (bigEndian != (std::endian::native == std::endian::big))
      std::reverse(bytes.begin(), bytes.end());
    out += bytes;
  }
  return out;
}

class VolumeFile : public ::testing::Test {
 protected:
  VolumeFile() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / (std::string("cloudcontact_volume_") + info->name());
    fs::create_directories(folder_);
  }
  ~VolumeFile() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  // What reading says; "accepted" where it says nothing.
  std::string fault(const std::string& name, const std::string& bytes,
                    const VolumeFileSettings& settings = {}) const {
    try {
      loadVolume(write(name, bytes), settings);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "accepted";
  }

  // The message says that, names the file and tells what to do.
  void expect(const std::string& found, const std::string& says) const {
    EXPECT_NE(found.find(says), std::string::npos) << found << "\n  lacks: " << says;
    EXPECT_NE(found.find(folder_.string()), std::string::npos) << found;
    EXPECT_NE(found.find(';'), std::string::npos) << "no remedy: " << found;
  }

  fs::path folder_;
};

// A header for a volume of cubes of half a millimeter, the center of the first at a quarter.
std::string nrrd(const std::string& type, const std::string& sizes, const std::string& rest) {
  return "NRRD0004\n# a scan\ntype: " + type +
         "\ndimension: 3\nspace: left-posterior-superior\nsizes: " + sizes +
         "\nspace directions: (0.5,0,0) (0,0.5,0) (0,0,0.5)\nspace origin: (0.25,0.25,0.25)\n"
         "space units: \"mm\" \"mm\" \"mm\"\nkinds: domain domain domain\nmodality:=CT\n" +
         rest;
}
std::string meta(const std::string& type, const std::string& sizes, const std::string& rest) {
  return "ObjectType = Image\nNDims = 3\nBinaryData = True\nOffset = 0.25 0.25 0.25\n"
         "TransformMatrix = 1 0 0 0 1 0 0 0 1\nElementSpacing = 0.5 0.5 0.5\nDimSize = " +
         sizes + "\nElementType = " + type + "\n" + rest;
}

void expectSame(const CtVolume& read, const CtVolume& truth, double tolerance = 0) {
  EXPECT_EQ(read.size, truth.size);
  EXPECT_LT((read.spacing - truth.spacing).norm(), 1e-12);
  EXPECT_LT((read.origin - truth.origin).norm(), 1e-12);
  ASSERT_EQ(read.values.size(), truth.values.size());
  double worst = 0;
  for (std::size_t k = 0; k < read.values.size(); ++k)
    worst = std::max(worst, std::abs(double(read.values[k]) - truth.values[k]));
  EXPECT_LE(worst, tolerance);
}

TEST_F(VolumeFile, EveryFormatHoldsTheSameBall) {
  const CtVolume truth = evenBall();
  const std::string sizes = "40 44 36", floats = bytesOf<float>(truth);
  const VolumeFileSettings mm{1e-3};
  expectSame(loadVolume(write("a.nrrd",
                              nrrd("float", sizes, "endian: little\nencoding: raw\n\n") + floats)),
             truth);
  expectSame(loadVolume(write("b.nrrd", nrrd("float", sizes, "endian: little\nencoding: gzip\n\n") +
                                            gzipped(floats))),
             truth);
  write("c.raw.gz", gzipped(floats));
  expectSame(loadVolume(write("c.nhdr", nrrd("float", sizes,
                                             "endian: little\nencoding: gzip\n"
                                             "data file: c.raw.gz\n"))),
             truth);
  write("d.raw", "head" + floats);
  expectSame(loadVolume(write("d.nhdr", nrrd("float", sizes,
                                             "endian: little\nencoding: raw\nbyte skip: 4\n"
                                             "data file: d.raw"))),
             truth);
  expectSame(loadVolume(write("d.mhd", meta("MET_FLOAT", sizes,
                                            "HeaderSize = -1\nElementDataFile = d.raw\n")),
                        mm),
             truth);
  expectSame(loadVolume(write("e.mha", meta("MET_FLOAT", sizes,
                                            "CompressedData = True\nElementDataFile = LOCAL\n") +
                                           packed(floats, 15)),
                        mm),
             truth);
}

TEST_F(VolumeFile, EveryTypeAndByteOrder) {
  const CtVolume truth = evenBall();
  const std::string sizes = "40 44 36";
  const auto read = [&](const std::string& type, const std::string& bytes, const char* endian) {
    return loadVolume(
        write("a.nrrd",
              nrrd(type, sizes, std::string("endian: ") + endian + "\nencoding: raw\n\n") + bytes));
  };
  expectSame(read("short", bytesOf<std::int16_t>(truth), "little"), truth, 1);
  expectSame(read("int16", bytesOf<std::int16_t>(truth, true), "big"), truth, 1);
  expectSame(read("int", bytesOf<std::int32_t>(truth, true), "big"), truth, 1);
  expectSame(read("long long", bytesOf<std::int64_t>(truth), "little"), truth, 1);
  expectSame(read("double", bytesOf<double>(truth, true), "big"), truth);
  CtVolume bright = truth;
  for (float& v : bright.values) v = (v + 1000) / 10;
  expectSame(read("uchar", bytesOf<std::uint8_t>(bright), "little"), bright, 1);
  for (float& v : bright.values) v -= 110;
  expectSame(read("signed char", bytesOf<std::int8_t>(bright), "little"), bright, 1);
  for (float& v : bright.values) v = 250 * (v + 110);
  expectSame(read("ushort", bytesOf<std::uint16_t>(bright), "little"), bright, 1);
  expectSame(read("uint32", bytesOf<std::uint32_t>(bright), "little"), bright, 1);
  expectSame(read("uint64", bytesOf<std::uint64_t>(bright), "little"), bright, 1);
}

// Slices along -y, rows along z, columns along -x: the ball stays where it was.
TEST_F(VolumeFile, AxesInAnyOrderAndDirection) {
  const CtVolume truth = ball({20, 22, 12}, Vec3(1e-3, 1e-3, 1.5e-3));
  CtVolume turned = truth;
  std::size_t k = 0;
  for (int y = 21; y >= 0; --y)
    for (int x = 19; x >= 0; --x)
      for (int z = 0; z < 12; ++z) turned.values[k++] = truth.values[x + 20 * (y + 22 * z)];
  const std::string data = bytesOf<float>(turned);
  expectSame(
      loadVolume(write("a.nrrd",
                       "NRRD0005\ntype: float\ndimension: 3\nsizes: 12 20 22\n"
                       "space: right-anterior-superior\nendian: little\nencoding: raw\n"
                       "space directions: (0,0,0.15) (-0.1,0,0) (0,-0.1,0)\n"
                       "space origin: (1.95,2.15,0.075)\nspace units: \"cm\" \"cm\" \"cm\"\n\n" +
                           data)),
      truth);
  expectSame(loadVolume(write("a.mha",
                              "ObjectType = Image\nNDims = 3\nDimSize = 12 20 22\n"
                              "ElementType = MET_FLOAT\nElementSpacing = 1.5 1 1\n"
                              "TransformMatrix = 0 0 1 -1 0 0 0 -1 0\nOffset = 19.5 21.5 0.75\n"
                              "ElementDataFile = LOCAL\n" +
                                  data),
                        {1e-3}),
             truth);
}

struct Scan {
  Vector3i size;
  Vec3 spacing;
  double voxel;  // [m]; 0: the smallest spacing
};

// Volume, center and moment of the ball by their formulas, for voxels of any size.
TEST_F(VolumeFile, ABallKeepsItsVolumeCenterAndInertia) {
  const Scan scans[] = {{{40, 44, 36}, Vec3::Constant(5e-4), 0},
                        {{40, 44, 15}, Vec3(5e-4, 5e-4, 12e-4), 0},
                        {{40, 44, 36}, Vec3::Constant(5e-4), 7e-4},
                        {{40, 44, 36}, Vec3::Constant(5e-4), 3e-4},
                        {{80, 88, 72}, Vec3::Constant(2.5e-4), 5e-4}};
  for (const Scan& scan : scans) {
    const CtVolume v = ball(scan.size, scan.spacing);
    std::ostringstream header;
    header << "NRRD0004\ntype: short\ndimension: 3\nsizes: " << scan.size.transpose()
           << "\nspacings: " << scan.spacing.transpose()
           << "\nspace origin: " << (scan.spacing / 2).transpose()
           << "\nencoding: gzip\nendian: little\n\n";
    const auto file = write("a.nrrd", header.str() + gzipped(bytesOf<std::int16_t>(v)));
    const CtVolume read = loadVolume(file, {1, scan.voxel});
    const Cloud cloud = cloudFromCt(read, {{-300, "bone"}}, {scan.voxel});
    const double voxel = scan.voxel > 0 ? scan.voxel : scan.spacing.minCoeff();
    EXPECT_NEAR(cloud.voxelSize(), voxel, 1e-9);
    const MassProperties mass = cloud.massProperties();
    const double volume = 4 / 3.0 * std::numbers::pi * std::pow(kRadius, 3);
    const double moment = 0.4 * volume * kRadius * kRadius;
    EXPECT_NEAR(mass.volume, volume, 5e-4 * volume);
    EXPECT_LT((mass.centerOfMass - kMiddle).norm(), 1e-3 * voxel);
    EXPECT_LT((mass.inertia / moment - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 5e-4);
  }
}

// Blocks of values are read as their means; the last block of an axis may be incomplete.
TEST_F(VolumeFile, BlocksAreMeans) {
  std::string data;
  for (int k = 0; k < 5 * 2 * 2; ++k) data += static_cast<char>(k);
  const CtVolume v =
      loadVolume(write("a.nrrd",
                       "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 5 2 2\nspacings: 1 1 1\n"
                       "encoding: raw\n\n" +
                           data),
                 {1, 2});
  EXPECT_EQ(v.size, Vector3i(3, 1, 1));
  EXPECT_LT((v.spacing - Vec3(2, 2, 2)).norm(), 1e-12);
  EXPECT_LT((v.origin - Vec3::Constant(-0.5)).norm(), 1e-12);
  // Means of 0 1 5 6 10 11 15 16, of 2 3 ... and of 4 9 14 19.
  EXPECT_EQ(v.values, (std::vector<float>{8, 10, 11.5}));
}

// A header of eight values in raw bytes.
std::string head(const char* type) {
  return nrrd(type, "2 2 2", "endian: little\nencoding: raw\n\n");
}

TEST_F(VolumeFile, BrokenDataAreRefused) {
  const std::string sizes = "2 2 2", eight(8, 'x'), sixteen(16, 'x');
  expect(fault("a.nrrd", head("short") + eight), "8 bytes of values");
  expect(fault("a.nrrd", head("uchar") + sixteen), "16 bytes of values");
  expect(fault("a.nrrd", nrrd("uchar", sizes, "encoding: gzip\n\n") + gzipped(sixteen)), "more");
  expect(fault("a.nrrd", nrrd("uchar", "2 2 3", "encoding: gzip\n\n") + gzipped(eight)), "fewer");
  const std::string whole = gzipped(eight);
  expect(fault("a.nrrd", nrrd("uchar", sizes, "encoding: gzip\n\n") + whole.substr(0, 12)),
         "cut short");
  expect(fault("a.nrrd", nrrd("uchar", sizes, "encoding: gzip\n\n") + "no gzip at all"), "damaged");
  std::string damaged = whole;
  damaged[whole.size() - 6] ^= 1;  // in the checksum
  expect(fault("a.nrrd", nrrd("uchar", sizes, "encoding: gzip\n\n") + damaged), "damaged");
  expect(fault("a.nrrd", nrrd("uchar", "2000000 2000000 2000000", "encoding: gzip\n\n") + whole),
         "GB");
  expect(fault("a.nrrd", nrrd("uchar", "200 200 200", "encoding: gzip\n\n") + whole), "cut short");
  CtVolume nan;
  nan.values = {0, 0, 0, 0, 0, std::numeric_limits<float>::quiet_NaN(), 0, 0};
  expect(fault("a.nrrd", head("float") + bytesOf<float>(nan)), "value 1 0 1 is NaN");
}

TEST_F(VolumeFile, BrokenHeadersAreRefused) {
  const std::string sizes = "2 2 2", end = "endian: little\nencoding: raw\n\n";
  const std::string eight(8, 'x'), sixteen(16, 'x');
  expect(fault("a.nrrd", "PNG"), "NRRD000");
  expect(fault("a.nrrd", std::string("\0\0\0", 3)), "header");
  expect(fault("a.nrrd", "NRRD0004\ntype: uchar\n\n"), "dimension");
  expect(fault("a.nrrd", head("block") + eight), "type");
  expect(fault("a.nrrd", nrrd("uchar", "2 2", end) + eight), "sizes");
  expect(fault("a.nrrd", nrrd("uchar", "2 2 -2", end) + eight), "sizes");
  expect(fault("a.nrrd", nrrd("uchar", "2 2 two", end) + eight), "sizes");
  expect(fault("a.nrrd", nrrd("uchar", sizes, "encoding: hex\n\n") + eight), "encoding");
  expect(fault("a.nrrd", nrrd("short", sizes, "encoding: raw\n\n") + sixteen), "endian");
  expect(fault("a.nhdr", nrrd("uchar", sizes, "encoding: raw\ndata file: none.raw\n")), "none.raw");
  expect(fault("a.nhdr", nrrd("uchar", sizes, "encoding: raw\ndata file: LIST\n")), "several");
  std::string spaced = head("uchar") + eight;
  spaced.replace(spaced.find("(0.5,0,0)"), 9, "(0.5,0.2,0)");
  expect(fault("a.nrrd", spaced), "along x, y and z");
  spaced.replace(spaced.find("(0.5,0.2,0)"), 11, "(0,0,0)");
  expect(fault("a.nrrd", spaced), "not positive");
  std::string mirrored = head("uchar") + eight;
  mirrored.replace(mirrored.find("left-posterior"), 14, "left-anterior");
  expect(fault("a.nrrd", mirrored), "mirrored");
}

TEST_F(VolumeFile, BrokenMetaImagesAreRefused) {
  const std::string sizes = "2 2 2", eight(8, 'x');
  expect(fault("a.mhd", meta("MET_UCHAR", sizes, "")), "elementdatafile");
  expect(fault("a.mhd", meta("MET_UCHAR", sizes, "ElementDataFile = none.raw\n")), "none.raw");
  expect(fault("a.mha", meta("MET_STRING", sizes, "ElementDataFile = LOCAL\n") + eight),
         "elementtype");
  expect(fault("a.mha",
               meta("MET_UCHAR", sizes, "ElementNumberOfChannels = 3\nElementDataFile = LOCAL\n") +
                   eight),
         "channels");
  expect(fault("a.mha", meta("MET_SHORT", sizes, "ElementDataFile = LOCAL\n") + eight),
         "8 bytes of values");
  EXPECT_THROW(loadVolume(folder_ / "none.nrrd"), std::runtime_error);
  EXPECT_THROW(loadVolume(write("a.dcm", "x")), std::runtime_error);
}

// Values that become few blocks are read in rows all the same.
TEST_F(VolumeFile, HugeRowsAreRefused) {
  const std::string zeros = gzipped(std::string(3 << 20, '\0'));
  const auto file = write("a.nrrd", nrrd("uchar", "3145728 1 1", "encoding: gzip\n\n") + zeros);
  VolumeFileSettings settings;
  settings.voxelSize = 1e9;
  EXPECT_EQ(loadVolume(file, settings).values.size(), 1u);
  settings.maxBytes = 1 << 20;
  EXPECT_THROW(loadVolume(file, settings), std::runtime_error);
}

// The voxel that the message names fits.
TEST_F(VolumeFile, TooLargeVolumesNameAVoxelThatFits) {
  const CtVolume truth = evenBall();
  const auto file = write("a.nrrd", nrrd("float", "40 44 36", "endian: little\nencoding: raw\n\n") +
                                        bytesOf<float>(truth));
  VolumeFileSettings settings;
  settings.maxBytes = 40000;
  std::string message;
  try {
    loadVolume(file, settings);
  } catch (const std::length_error& error) {
    message = error.what();
  }
  const std::string before = "voxelSize of ";
  ASSERT_NE(message.find(before), std::string::npos) << message;
  settings.voxelSize = std::stod(message.substr(message.find(before) + before.size()));
  EXPECT_LE(loadVolume(file, settings).values.size() * sizeof(float), settings.maxBytes);
}

}  // namespace
}  // namespace cloudcontact::volume_file_test
