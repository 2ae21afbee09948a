// Packs a surface field for the device, and manages the one buffer of all fields.
#include "device/device_fields.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace cloudcontact::opencl {

namespace {

constexpr std::size_t kAlign = 256;
// Offsets are 32-bit counts of 4-byte words.
constexpr std::size_t kMaxBytes = std::size_t{4} << 32;

// Appends arrays, each aligned, and returns their offsets in units of their type.
class Packer {
 public:
  explicit Packer(std::size_t begin) : begin_(begin) {}

  template <typename T>
  std::uint32_t add(const T* first, std::size_t count, std::size_t unit = sizeof(T)) {
    bytes_.resize((bytes_.size() + 15) / 16 * 16);
    const std::size_t at = bytes_.size();
    bytes_.resize(at + count * sizeof(T));
    if (count > 0) std::memcpy(bytes_.data() + at, first, count * sizeof(T));
    return static_cast<std::uint32_t>((begin_ + at) / unit);
  }
  const std::vector<unsigned char>& bytes() const { return bytes_; }

 private:
  std::size_t begin_;
  std::vector<unsigned char> bytes_;
};

// Four arrays as one array of (a, b, c, d).
std::vector<float> interleaved(const LargeVector<float>& a, const LargeVector<float>& b,
                               const LargeVector<float>& c, const LargeVector<float>& d) {
  std::vector<float> all;
  all.reserve(4 * a.size());
  for (std::size_t i = 0; i < a.size(); ++i) all.insert(all.end(), {a[i], b[i], c[i], d[i]});
  return all;
}

constexpr std::size_t kQuad = 4 * sizeof(float);

void packLevel(const SampleLevel& level, int number, Packer& packer, CcField& entry) {
  const SampleColumns& s = level.samples;
  std::vector<float> both = interleaved(s.x, s.y, s.z, s.width);
  const std::vector<float> normals = interleaved(s.nx, s.ny, s.nz, s.area);
  both.insert(both.end(), normals.begin(), normals.end());
  std::vector<float> clusters;
  for (std::size_t k = 0; k < level.clusters.size(); ++k) {
    const CcCluster e = level.clusters[k];
    clusters.push_back(e.rise);
    clusters.insert(clusters.end(), e.spread, e.spread + 6);
    clusters.push_back(0);
  }
  entry.clusters[number] = packer.add(clusters.data(), clusters.size(), kQuad);
  entry.counts[number] = static_cast<std::uint32_t>(s.size());
  entry.samples[number] = packer.add(both.data(), both.size(), kQuad);
  entry.cells[number] = packer.add(level.cellOf.data(), level.cellOf.size());
  entry.finer[number] = packer.add(level.finer.data(), level.finer.size());
}

CcField pack(const FieldData& field, Packer& packer) {
  CcField entry{};
  const FieldRecords& records = field.records();
  const CcBricks bricks = records.bricks();
  entry.nx = bricks.nx, entry.ny = bricks.ny, entry.nz = bricks.nz;
  entry.voxel = static_cast<float>(field.cloud().voxelSize());
  const std::size_t count = field.brickDistance().size();
  const std::vector<std::int32_t> distance(field.brickDistance().begin(),
                                           field.brickDistance().end());
  entry.records = packer.add(records.records(), records.size());
  entry.planes = packer.add(field.planes(), field.planeCount());
  entry.firsts = packer.add(records.firsts(), count + 1);
  entry.between = packer.add(records.between(), count);
  entry.distance = packer.add(distance.data(), count);
  for (int level = 0; level < kLevels; ++level)
    packLevel(field.samples().levels[level], level, packer, entry);
  const SampleBricks& b = field.samples().bricks;
  const std::vector<float> spheres = interleaved(b.x, b.y, b.z, b.radius);
  entry.bricks = packer.add(spheres.data(), spheres.size(), kQuad);
  entry.runs = packer.add(b.runs.data(), b.runs.size());
  entry.brickCount = static_cast<std::uint32_t>(b.runs.size());
  return entry;
}

std::string megabytes(std::size_t bytes) {
  return std::to_string((bytes + 999999) / 1000000) + " MB";
}

}  // namespace

std::uint32_t DeviceFields::indexOf(const FieldData& field) {
  const auto known = indices_.find(&field);
  // A new field may have the address of one that was freed, hence life().
  if (known != indices_.end() && kept_[known->second].life.lock() == field.life())
    return known->second;
  return send(field);
}

std::uint32_t DeviceFields::send(const FieldData& field) {
  forgetDead();
  Packer measure(0);
  pack(field, measure);
  const std::size_t size = (measure.bytes().size() + kAlign - 1) / kAlign * kAlign;
  Kept kept{&field, field.life(), findRoom(size), size, {}};
  Packer packer(kept.begin);
  kept.entry = pack(field, packer);
  device_->queue().enqueueWriteBuffer(data_, CL_TRUE, kept.begin, packer.bytes().size(),
                                      packer.bytes().data(), nullptr, device_->note("fields sent"));
  auto slot = std::find_if(kept_.begin(), kept_.end(), [](const Kept& k) { return !k.field; });
  if (slot == kept_.end()) slot = kept_.insert(kept_.end(), Kept{});
  *slot = std::move(kept);
  changed_ = true;
  return indices_[&field] = static_cast<std::uint32_t>(slot - kept_.begin());
}

void DeviceFields::forgetDead() {
  for (Kept& k : kept_) {
    if (!k.field || !k.life.expired()) continue;
    indices_.erase(k.field);
    k = Kept{};
  }
}

// Offset of the first gap that is large enough, or of the end.
std::size_t DeviceFields::findRoom(std::size_t size) {
  std::vector<std::pair<std::size_t, std::size_t>> used;
  for (const Kept& k : kept_)
    if (k.field) used.emplace_back(k.begin, k.begin + k.size);
  std::sort(used.begin(), used.end());
  std::size_t at = 0;
  for (const auto& [begin, end] : used) {
    if (begin - at >= size) break;
    at = end;
  }
  if (at + size > room_) enlarge(at + size);
  return at;
}

void DeviceFields::enlarge(std::size_t size) {
  const std::size_t most = std::min({kMaxBytes, device_->largestBuffer(), device_->memory() / 2});
  if (size > most)
    throw std::runtime_error("OpenCL: the fields need " + megabytes(size) + ", but " +
                             device_->name() + " can hold only " + megabytes(most) +
                             "; use larger voxels or the CPU");
  std::size_t room = std::min(most, std::max(size, 2 * room_));
  cl::Buffer larger;
  try {
    larger = cl::Buffer(device_->context(), CL_MEM_READ_ONLY, room);
  } catch (const cl::Error&) {
    room = size;  // without room to grow
    larger = cl::Buffer(device_->context(), CL_MEM_READ_ONLY, room);
  }
  if (room_ > 0) device_->queue().enqueueCopyBuffer(data_, larger, 0, 0, room_);
  device_->queue().finish();
  data_ = larger;
  room_ = room;
}

void DeviceFields::sendTable() {
  if (!changed_) return;
  std::vector<CcField> entries;
  for (const Kept& k : kept_) entries.push_back(k.entry);
  if (entries.size() > tableRoom_) {
    table_ = cl::Buffer(device_->context(), CL_MEM_READ_ONLY, 2 * entries.size() * sizeof(CcField));
    tableRoom_ = 2 * entries.size();
  }
  device_->queue().enqueueWriteBuffer(table_, CL_TRUE, 0, entries.size() * sizeof(CcField),
                                      entries.data());
  changed_ = false;
}

}  // namespace cloudcontact::opencl
