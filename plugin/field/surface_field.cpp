// SurfaceField: built from a cloud in four steps (field_builder.h), then read.
#include "field/field_data.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace cloudcontact {

namespace {

// FNV-1a over 8 bytes at a time (Fowler, Noll, Vo), each made unlike its neighbours first.
class Hasher {
 public:
  template <typename T>
  void add(const T* first, std::size_t count) {
    const auto* const bytes = reinterpret_cast<const unsigned char*>(first);
    mix(count);
    for (std::size_t i = 0; i < count * sizeof(T); i += 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, bytes + i, std::min<std::size_t>(8, count * sizeof(T) - i));
      mix(word);
    }
  }
  std::uint64_t value() const { return value_; }

 private:
  void mix(std::uint64_t word) {
    value_ = (value_ ^ word) * 0x100000001b3u;
    value_ ^= value_ >> 29;
  }
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

// Two sweeps of a Chebyshev distance transform over the table of bricks.
std::vector<std::uint8_t> distanceToBand(const Eigen::Vector3i& n,
                                         std::vector<std::uint8_t> distance) {
  const auto index = [&](int x, int y, int z) {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(n.x()) *
               (static_cast<std::size_t>(y) +
                static_cast<std::size_t>(n.y()) * static_cast<std::size_t>(z));
  };
  for (int axis = 0; axis < 3; ++axis) {
    // Per axis: d(x) = min over y of max(d(y), |x - y|), by relaxing along the line both ways.
    std::vector<std::uint8_t> line(static_cast<std::size_t>(n[axis]));
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    for (int j = 0; j < n[b]; ++j)
      for (int i = 0; i < n[a]; ++i) {
        Eigen::Vector3i at;
        at[a] = i;
        at[b] = j;
        for (int k = 0; k < n[axis]; ++k) {
          at[axis] = k;
          line[static_cast<std::size_t>(k)] = distance[index(at.x(), at.y(), at.z())];
        }
        for (int k = 0; k < n[axis]; ++k) {
          int best = 255;
          for (int r = 0; r < best && r < n[axis]; ++r)
            for (int side : {-r, r})
              if (k + side >= 0 && k + side < n[axis])
                best = std::min(
                    best, std::max(r, static_cast<int>(line[static_cast<std::size_t>(k + side)])));
          at[axis] = k;
          distance[index(at.x(), at.y(), at.z())] = static_cast<std::uint8_t>(best);
        }
      }
  }
  return distance;
}

// The distances of an earlier field hold where the band has the same bricks.
std::vector<std::uint8_t> distancesOf(const Cloud& cloud, const BandSource& source,
                                      const FieldData* before) {
  std::vector<std::uint8_t> inBand(source.size());
  bool same = before != nullptr;
  for (std::size_t t = 0; t < inBand.size(); ++t) {
    inBand[t] = source.view(t).cells ? 0 : 255;
    same = same && (inBand[t] == 0) == (before->brickDistance()[t] == 0);
  }
  return same ? before->brickDistance() : distanceToBand(cloud.bricks(), std::move(inBand));
}

}  // namespace

std::shared_ptr<const SurfaceField> SurfaceField::build(const Cloud& cloud,
                                                        const FieldSettings& settings) {
  if (cloud.empty()) throw std::invalid_argument("SurfaceField::build: the cloud is empty");
  if ((cloud.size().array() > 32767).any())
    throw std::invalid_argument(
        "SurfaceField::build: more than 32767 voxels along an axis; take a larger voxel");
  FieldDraft draft(cloud, settings);
  const auto report = [&](double done) {
    if (settings.progress) settings.progress(done);
  };
  fitSurfaceVoxels(draft);
  if (draft.surfaceBricks().empty())
    throw std::invalid_argument("SurfaceField::build: the cloud has no surface");
  report(0.4);
  resolveEdges(draft);
  report(0.7);
  FieldData::Parts parts;
  auto notes = std::make_shared<FieldNotes>();
  parts.samples = sortSamples(cutSamples(draft), notes->origins);
  report(0.8);
  parts.band = spreadBand(draft);
  if (settings.renewable) {
    notes->bricks = draft.bricks();
    parts.notes = std::move(notes);
  }
  report(1.0);
  return std::make_shared<FieldData>(cloud, std::move(parts));
}

FieldData::FieldData(Cloud cloud, Parts parts)
    : FieldData(std::move(cloud), parts, BandSource(parts.band, parts.before)) {}

FieldData::FieldData(Cloud cloud, Parts& parts, const BandSource& source)
    : cloud_(std::move(cloud)),
      planes_(source),
      distance_(distancesOf(cloud_, source, parts.before)),
      records_(cloud_, source, planes_, distance_),
      samples_(std::move(parts.samples)),
      notes_(std::move(parts.notes)) {
  const SampleColumns& all = samples_.levels[0].samples;
  for (std::size_t k = 0; k < all.size(); ++k)
    bounds_.extend(cloud_.origin() + cloud_.voxelSize() * Vec3(all.x[k], all.y[k], all.z[k]));
}

BandView FieldData::bandBrick(std::size_t brick) const {
  if (distance_[brick] > 0) return {};
  const std::uint32_t first = planes_.firsts[brick];
  return {records_.records() + records_.firsts()[brick], planes_.planes.data() + first,
          planes_.firsts[brick + 1] - first, first};
}

std::size_t FieldData::bytes() const {
  std::size_t sum = records_.bytes() + distance_.size() + samples_.bytes() +
                    planes_.planes.size() * sizeof(CcVoxel) +
                    planes_.firsts.size() * sizeof(std::uint32_t);
  if (!notes_) return sum;
  sum += notes_->origins.size() * sizeof(SampleOrigin);
  for (const auto& brick : notes_->bricks)
    if (brick)
      sum += sizeof(SurfaceBrick) + brick->voxels.size() * sizeof(SurfaceVoxel) +
             brick->steps.size() * sizeof(VoxelStep) + brick->pieces.size() * sizeof(SurfacePiece);
  return sum;
}

// Over all that a query reads, in the order in which it lies in memory.
std::uint64_t FieldData::hash() const {
  Hasher hasher;
  const std::size_t bricks = distance_.size();
  hasher.add(records_.records(), records_.size());
  hasher.add(records_.firsts(), bricks + 1);
  hasher.add(records_.between(), bricks);
  hasher.add(planes_.planes.data(), planes_.planes.size());
  hasher.add(distance_.data(), bricks);
  for (const SampleLevel& level : samples_.levels) {
    const SampleColumns& s = level.samples;
    for (const auto* column : {&s.x, &s.y, &s.z, &s.nx, &s.ny, &s.nz, &s.area, &s.width})
      hasher.add(column->data(), column->size());
    hasher.add(level.cellOf.data(), level.cellOf.size());
    hasher.add(level.finer.data(), level.finer.size());
  }
  const SampleBricks& b = samples_.bricks;
  for (const auto* column : {&b.x, &b.y, &b.z, &b.radius})
    hasher.add(column->data(), column->size());
  hasher.add(b.runs.data(), b.runs.size());
  for (int axis = 0; axis < 3; ++axis) {
    hasher.add(&bounds_.min()[axis], 1);
    hasher.add(&bounds_.max()[axis], 1);
  }
  return hasher.value();
}

std::optional<FieldPoint> FieldData::at(const Vec3& local) const {
  const Vec3 g = (local - cloud_.origin()) / cloud_.voxelSize();
  if (!(g.array().abs() < 32767.0).all()) return std::nullopt;
  const Eigen::Vector3i v = g.array().floor().cast<int>();
  const CcVoxel record = records_.at(v.x(), v.y(), v.z());
  if (ccPlaneCount(record) == 0) return std::nullopt;
  const Vec3 r = g - v.cast<double>() - Vec3::Constant(0.5);
  const float x[3] = {float(r.x()), float(r.y()), float(r.z())};
  const CcDepth d = ccVoxelDepth(record, planes(), x);
  return FieldPoint{d.depth * cloud_.voxelSize(), Vec3(d.normal[0], d.normal[1], d.normal[2])};
}

}  // namespace cloudcontact
