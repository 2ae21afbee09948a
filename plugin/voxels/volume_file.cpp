// Values are read row by row. Blocks of them are summed up in layers of the volume, which then
// become values in the order x, y, z.
#include <cloudcontact/voxels/volume_file.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "base/file_name.h"
#include "base/grid_index.h"
#include "voxels/volume_header.h"

namespace cloudcontact {

namespace {

namespace fs = std::filesystem;
using Eigen::Vector3i;

constexpr double kOblique = 1e-3;     // of an axis' length, across x, y or z
constexpr double kMostPacked = 1032;  // bytes in one byte of compressed data
constexpr double kHair = 1e-6;        // rounding error of a ratio of lengths

// The bytes of the values, unpacked.
class Bytes {
 public:
  Bytes(const VolumeHeader& header, double count) : file_(header.data), zipped_(header.isZipped) {
    in_ = openFile(file_, "a volume file");
    const auto length = static_cast<double>(fs::file_size(file_));
    const double skip = header.skip < 0 ? length - count : static_cast<double>(header.skip);
    if (!zipped_ && (skip < 0 || length - skip != count)) refuseLength(length - skip, count);
    in_.seekg(static_cast<std::streamoff>(skip));
    if (!zipped_) return;
    if (kMostPacked * (length - skip) < count)
      refuseFile(file_, "is cut short, or its sizes are wrong; save it again");
    // 32: gzip or zlib, whichever the data begin with.
    if (inflateInit2(&stream_, 15 + 32) != Z_OK) throw std::bad_alloc();
  }
  ~Bytes() {
    if (zipped_) inflateEnd(&stream_);
  }
  Bytes(const Bytes&) = delete;
  Bytes& operator=(const Bytes&) = delete;

  void read(char* to, std::size_t count) {
    if (zipped_) return unpack(to, count);
    if (!in_.read(to, static_cast<std::streamsize>(count)))
      refuseFile(file_, "cannot be read to its end; copy it again");
  }
  // To be called after the last value.
  void finish() {
    if (!zipped_) return;
    Bytef more = 0;
    stream_.next_out = &more;
    stream_.avail_out = 1;
    while (!ended_ && stream_.avail_out > 0) inflateMore();
    if (stream_.avail_out == 0)
      refuseFile(file_, "holds more values than its sizes say; correct the sizes");
  }

 private:
  [[noreturn]] void refuseLength(double found, double needed) const {
    std::ostringstream text;
    text.precision(15);
    text << "holds " << std::max(found, 0.0) << " bytes of values where its sizes and type need "
         << needed << "; " << (found < needed ? "it is cut short, or the" : "correct the")
         << " sizes or the type" << (found < needed ? " are wrong: save it again" : "");
    refuseFile(file_, text.str());
  }
  void unpack(char* to, std::size_t count) {
    while (count > 0) {
      const auto part = static_cast<uInt>(std::min<std::size_t>(count, 1 << 30));
      stream_.next_out = reinterpret_cast<Bytef*>(to);
      stream_.avail_out = part;
      while (stream_.avail_out > 0) {
        if (ended_) refuseFile(file_, "holds fewer values than its sizes say; correct the sizes");
        inflateMore();
      }
      to += part, count -= part;
    }
  }
  void inflateMore() {
    if (stream_.avail_in == 0) {
      in_.read(packed_, sizeof(packed_));
      stream_.next_in = reinterpret_cast<Bytef*>(packed_);
      stream_.avail_in = static_cast<uInt>(in_.gcount());
      if (stream_.avail_in == 0)
        refuseFile(file_, "is cut short: its compressed data end early; save it again");
    }
    const int code = inflate(&stream_, Z_NO_FLUSH);
    ended_ = code == Z_STREAM_END;
    if (!ended_ && code != Z_OK && code != Z_BUF_ERROR)
      refuseFile(file_, "holds compressed data that are damaged; save it again");
  }

  fs::path file_;
  std::ifstream in_;
  bool zipped_, ended_ = false;
  z_stream stream_{};
  char packed_[1 << 16];
};

template <typename Number>
double numberAt(const char* bytes, bool swapped) {
  char turned[sizeof(Number)];
  std::memcpy(turned, bytes, sizeof(Number));
  if (swapped) std::reverse(turned, turned + sizeof(Number));
  Number number;
  std::memcpy(&number, turned, sizeof(Number));
  return static_cast<double>(number);
}

using Convert = double (*)(const char*, bool);
Convert converter(ValueType type) {
  constexpr Convert kConverters[] = {numberAt<std::int8_t>,  numberAt<std::uint8_t>,
                                     numberAt<std::int16_t>, numberAt<std::uint16_t>,
                                     numberAt<std::int32_t>, numberAt<std::uint32_t>,
                                     numberAt<std::int64_t>, numberAt<std::uint64_t>,
                                     numberAt<float>,        numberAt<double>};
  return kConverters[static_cast<std::size_t>(type)];
}

// How the file's axes lie in x, y, z, and which blocks of values become one.
struct Layout {
  Vector3i axis;     // of x, y, z for each of the file's axes
  bool isTurned[3];  // the file's axis runs against it
  Vec3 spacing;      // along the file's axes, from value to value [m]
  Vector3i block;    // values along the file's axes
  Vector3i blocks;   // number of blocks along the file's axes
};

Layout layoutOf(const fs::path& file, const VolumeHeader& header, double unit, double voxel) {
  Layout out;
  bool isUsed[3] = {};
  for (int k = 0; k < 3; ++k) {
    const Vec3 step = unit * header.axes.col(k);
    out.spacing[k] = step.cwiseAbs().maxCoeff(&out.axis[k]);
    const int a = out.axis[k];
    if (!(out.spacing[k] > 0) || !std::isfinite(out.spacing[k]))
      refuseFile(file, "has a spacing that is not positive; correct it");
    if ((step - step[a] * Vec3::Unit(a)).norm() > kOblique * out.spacing[k] || isUsed[a])
      refuseFile(file, "has axes that are not along x, y and z; resample it along them");
    isUsed[a] = true;
    out.isTurned[k] = step[a] < 0;
    const double fit = std::floor(voxel / out.spacing[k] + kHair);
    out.block[k] = static_cast<int>(std::clamp(fit, 1.0, double(header.size[k])));
    out.blocks[k] = (header.size[k] + out.block[k] - 1) / out.block[k];
  }
  return out;
}

// A volume without values.
CtVolume emptyVolume(const VolumeHeader& header, const Layout& layout, double unit) {
  CtVolume out;
  for (int k = 0; k < 3; ++k) {
    const int a = layout.axis[k];
    const double step = layout.spacing[k], edge = step * layout.block[k];
    const double first = unit * header.first[a];
    out.size[a] = layout.blocks[k];
    out.spacing[a] = edge;
    out.origin[a] =
        layout.isTurned[k] ? first + step / 2 - edge * layout.blocks[k] : first - step / 2;
  }
  return out;
}

void refuseMemory(const fs::path& file, const CtVolume& volume, std::size_t most) {
  const double bytes = volume.size.cast<double>().prod() * sizeof(float);
  if (bytes <= static_cast<double>(most)) return;
  // Blocks are of whole values, so twice the spacing is the next voxel that helps.
  const double grow = std::max(2.0, std::ceil(std::cbrt(bytes / static_cast<double>(most))));
  std::ostringstream text;
  text << file.string() << ": its " << volume.size.transpose() << " values would need "
       << bytes / 1e9 << " GB, more than " << static_cast<double>(most) / 1e9
       << "; choose a voxelSize of " << grow * volume.spacing.maxCoeff() << " m or larger";
  throw std::length_error(text.str());
}

// What is read at once: a row of values, and the sums of a layer of blocks.
void refuseMemory(const VolumeHeader& header, const Layout& layout, std::size_t most) {
  const double row = double(bytesOf(header.type)) * header.size.x();
  const double layer = double(sizeof(double) + sizeof(int)) * layout.blocks.x() * layout.blocks.y();
  if (std::max(row, layer) > static_cast<double>(most))
    refuseFile(header.data,
               "has sizes of which a layer alone needs more memory than maxBytes; "
               "correct the sizes, or save it with its axes in another order");
}

// One layer of blocks: sums of its values, and how many they are.
struct Layer {
  std::vector<double> sums;
  std::vector<int> counts;
  explicit Layer(std::size_t n) : sums(n, 0), counts(n, 0) {}
};

// Adds a row of values to the blocks of row `y` of the layer.
void addRow(const VolumeHeader& header, const Layout& layout, const std::vector<char>& row,
            const Vector3i& at, Layer& layer) {
  const Convert convert = converter(header.type);
  const bool swapped = header.isBigEndian != (std::endian::native == std::endian::big);
  const std::size_t bytes = bytesOf(header.type);
  const std::size_t start = static_cast<std::size_t>(at.y() / layout.block.y()) *
                            static_cast<std::size_t>(layout.blocks.x());
  for (int x = 0; x < header.size.x(); ++x) {
    const double value = convert(row.data() + bytes * static_cast<std::size_t>(x), swapped);
    if (!std::isfinite(value) || std::abs(value) > std::numeric_limits<float>::max())
      refuseFile(header.data, "value " + std::to_string(x) + " " + std::to_string(at.y()) + " " +
                                  std::to_string(at.z()) +
                                  " is NaN or infinite; replace it by the value of air");
    const std::size_t k = start + static_cast<std::size_t>(x / layout.block.x());
    layer.sums[k] += value;
    ++layer.counts[k];
  }
}

void store(const Layer& layer, int z, const Layout& layout, CtVolume& out) {
  for (std::size_t k = 0; k < layer.sums.size(); ++k) {
    const auto n = static_cast<std::size_t>(layout.blocks.x());
    const int from[3] = {static_cast<int>(k % n), static_cast<int>(k / n), z};
    Vector3i to;
    for (int a = 0; a < 3; ++a)
      to[layout.axis[a]] = layout.isTurned[a] ? layout.blocks[a] - 1 - from[a] : from[a];
    out.values[gridIndex(to, out.size)] = static_cast<float>(layer.sums[k] / layer.counts[k]);
  }
}

void readValues(const VolumeHeader& header, const Layout& layout, CtVolume& out) {
  const std::size_t rowBytes = bytesOf(header.type) * static_cast<std::size_t>(header.size.x());
  const auto bytes = std::make_unique<Bytes>(
      header, double(bytesOf(header.type)) * header.size.cast<double>().prod());
  out.values.resize(out.size.cast<std::size_t>().prod());
  std::vector<char> row(rowBytes);
  const Layer empty(static_cast<std::size_t>(layout.blocks.x()) *
                    static_cast<std::size_t>(layout.blocks.y()));
  for (int z = 0; z < header.size.z();) {
    Layer layer = empty;
    const int block = z / layout.block.z(), end = (block + 1) * layout.block.z();
    for (; z < std::min(end, header.size.z()); ++z)
      for (int y = 0; y < header.size.y(); ++y) {
        bytes->read(row.data(), row.size());
        addRow(header, layout, row, {0, y, z}, layer);
      }
    store(layer, block, layout, out);
  }
  bytes->finish();
}

bool isNrrd(const fs::path& file) {
  const std::string extension = lowerExtension(file);
  return extension == ".nrrd" || extension == ".nhdr";
}

}  // namespace

bool isVolumeFile(const fs::path& file) {
  const std::string extension = lowerExtension(file);
  return isNrrd(file) || extension == ".mha" || extension == ".mhd";
}

CtVolume loadVolume(const fs::path& file, const VolumeFileSettings& settings) {
  if (!(settings.metersPerUnit > 0) || !std::isfinite(settings.metersPerUnit))
    refuseFile(file, "metersPerUnit must be positive and finite");
  if (!(settings.voxelSize >= 0) || !std::isfinite(settings.voxelSize))
    refuseFile(file, "voxelSize must be 0 or more, and finite");
  if (!isVolumeFile(file))
    refuseFile(file, "is of no known format; give a .nrrd, .nhdr, .mha or .mhd file");
  const VolumeHeader header = isNrrd(file) ? readNrrdHeader(file) : readMetaImageHeader(file);
  const double unit = header.metersPerUnit > 0 ? header.metersPerUnit : settings.metersPerUnit;
  const Layout layout = layoutOf(file, header, unit, settings.voxelSize);
  CtVolume volume = emptyVolume(header, layout, unit);
  refuseMemory(file, volume, settings.maxBytes);
  refuseMemory(header, layout, settings.maxBytes);
  readValues(header, layout, volume);
  return volume;
}

}  // namespace cloudcontact
