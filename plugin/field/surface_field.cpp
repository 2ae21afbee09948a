// Builds a field from a cloud in six steps (field_draft.h), or renews it after a cut.
#include <cloudcontact/field/surface_field.h>

#include "base/grid_index.h"
#include "field/field_band.h"
#include "field/field_bends.h"
#include "field/field_data.h"
#include "field/field_edges.h"
#include "field/field_fit.h"
#include "field/field_samples.h"
#include "field/sample_vectors.h"

#include <cstring>
#include <stdexcept>

namespace cloudcontact {

namespace {

const std::uint8_t* voxelsOf(const Cloud& cloud, std::size_t t) {
  static const auto kUniform = [] {
    std::array<BrickCoverage, 2> two;
    two[0].fill(0);
    two[1].fill(255);
    return two;
  }();
  const std::int32_t b = cloud.voxels().table[t];
  if (b >= 0) return cloud.voxels().coverage[static_cast<std::size_t>(b)].data();
  return kUniform[b == kSolidBrick ? 1 : 0].data();
}

// The bricks that hold no matter, and have none beside them. Where a large part fell off, most of
// what the field knew of it goes with such bricks, at no cost a voxel: all else lies 8 voxels away
// or more, which is farther than any step reads.
std::vector<std::int32_t> emptiedBricks(const Cloud& after) {
  std::vector<std::int32_t> emptied;
  const Eigen::Vector3i n = after.bricks();
  const std::vector<std::int32_t>& table = after.voxels().table;
  for (std::size_t t = 0; t < table.size(); ++t) {
    const Eigen::Vector3i at = gridCell(t, n);
    bool none = table[t] == kEmptyBrick;
    for (int k = 0; k < 27 && none; ++k) {
      const Eigen::Vector3i b = at + Eigen::Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      none = !insideGrid(b, n) || table[gridIndex(b, n)] == kEmptyBrick;
    }
    if (none) emptied.push_back(static_cast<std::int32_t>(t));
  }
  return emptied;
}

// What a field knew before, without the bricks that `after` has emptied.
struct Known {
  int drops = 0;  // bricks
  SurfaceBricks bricks;
  LayerBricks layers;
  EdgeQueue edges;
  std::vector<std::int32_t> emptied;
  VoxelSet dropped;  // emptied bricks that held something
  VoxelSet rim;      // around these, what may have read them

  Known(const FieldNotes& notes, const Cloud& after)
      : bricks(notes.bricks),
        layers(notes.layers),
        edges(notes.edges),
        emptied(emptiedBricks(after)),
        dropped(after.bricks()),
        rim(after.bricks()) {
    for (const std::int32_t t : emptied) {
      const std::size_t b = static_cast<std::size_t>(t);
      if (!bricks[b] && !layers[b]) continue;
      bricks[b] = nullptr;
      layers[b] = nullptr;
      edges.drop(t);
      dropped.addBrick(t);
      ++drops;
    }
    if (dropped.empty()) return;
    rim = dropped.dilated(kLayers + 1);
    rim.remove(dropped);
  }
};

// Voxels whose coverage differs, but for those of `emptied` bricks.
VoxelSet changedVoxels(const Cloud& before, const Cloud& after,
                       const std::vector<std::int32_t>& emptied) {
  VoxelSet changed(after.bricks());
  const Eigen::Vector3i n = after.bricks();
  auto skipped = emptied.begin();
  for (std::size_t t = 0; t < after.voxels().table.size(); ++t) {
    if (skipped != emptied.end() && static_cast<std::size_t>(*skipped) == t) {
      ++skipped;
      continue;
    }
    const std::uint8_t *const a = voxelsOf(before, t), *const b = voxelsOf(after, t);
    if (a == b || std::memcmp(a, b, kBrickVoxels) == 0) continue;
    for (int k = 0; k < kBrickVoxels; ++k) {
      if (a[k] == b[k]) continue;
      const Eigen::Vector3i v = kBrickEdge * gridCell(t, n) + cellOffset(k);
      changed.add(v.x(), v.y(), v.z());
    }
  }
  return changed;
}

// Of cut voxels, those that became less than half full, or more.
VoxelSet turnedVoxels(const Cloud& before, const Cloud& after, const VoxelSet& cut) {
  VoxelSet turned(after.bricks());
  cut.forEach([&](std::int32_t, int, int x, int y, int z) {
    if ((before.coverage(x, y, z) > 127) != (after.coverage(x, y, z) > 127)) turned.add(x, y, z);
  });
  return turned;
}

// What a renewal costs beside its steps [us]: itself, each brick that is dropped, each sample that
// is copied and then stored.
constexpr double kRenewalCost = 100, kDropCost = 4, kCopyCost = 0.018, kStoreCost = 0.012;

// The voxels whose pieces must be cut to samples again: changed ones, and those beside a voxel that
// came to hold an edge, or lost it.
VoxelSet recutVoxels(const FieldDraft& draft, const SurfaceBricks& before,
                     const VoxelSet& changed) {
  VoxelSet edges(draft.cloud.bricks());
  changed.forEach([&](std::int32_t t, int cell, int x, int y, int z) {
    const SurfaceBrick* const b = before[static_cast<std::size_t>(t)].get();
    const VoxelState old = b ? b->state(cell) : VoxelState{}, now = draft.at(x, y, z);
    if ((old && old.count() > 1) != (now && now.count() > 1)) edges.add(x, y, z);
  });
  VoxelSet recut = edges.dilated(1);
  recut.add(changed);
  return recut;
}

// Finds some edges of a new field, and leaves the others to renewals.
void beginEdges(FieldDraft& draft, EdgeQueue& edges, int most) {
  VoxelSet all(draft.cloud.bricks());
  for (const std::int32_t t : draft.surfaceBricks())
    for (const SurfaceVoxel& v : draft.brick(static_cast<std::size_t>(t))->voxels) {
      const DraftVoxel at = draft.voxelAt(t, v.cell);
      all.add(at.x, at.y, at.z);
    }
  renewEdges(draft, edges, SurfaceBricks(draft.bricks().size()), all, all, most);
}

void validate(const Cloud& cloud) {
  if (cloud.empty()) throw std::invalid_argument("SurfaceField::build: the cloud is empty");
  if ((cloud.size().array() > 32767).any())
    throw std::invalid_argument(
        "SurfaceField::build: more than 32767 voxels along an axis; use a larger voxel");
}

void validate(const SurfaceField* before, const Cloud& after) {
  if (!before) throw std::invalid_argument("renewed: there is no field to renew");
  if (after.empty()) throw std::invalid_argument("renewed: the cloud is empty");
  if (after.bricks() != before->cloud().bricks() ||
      after.voxelSize() != before->cloud().voxelSize())
    throw std::invalid_argument(
        "renewed: the cloud's grid differs from the field's; use SurfaceField::build()");
}

}  // namespace

std::shared_ptr<const SurfaceField> SurfaceField::build(const Cloud& cloud,
                                                        const FieldSettings& settings) {
  validate(cloud);
  FieldDraft draft(cloud, settings.threads, settings.spend);
  const auto report = [&](double done) {
    if (settings.progress) settings.progress(done);
  };
  fitVoxels(draft);
  if (draft.surfaceBricks().empty())
    throw std::invalid_argument("SurfaceField::build: the cloud has no surface");
  report(0.4);
  auto notes = std::make_shared<FieldNotes>(draft.cloud.bricks());
  if (settings.renewable && settings.edgeSearches)
    beginEdges(draft, notes->edges, *settings.edgeSearches);
  else
    findEdges(draft);
  report(0.7);
  std::vector<CutSample> pieces = cutSamples(draft);
  giveBaseVectors(draft, pieces);
  SampleSet samples = sortSamples(std::move(pieces), notes->origins);
  report(0.8);
  FieldLayers layers(draft);
  layers.spread();
  const Band band = writeBand(draft, layers);
  if (settings.renewable) {
    notes->bricks = draft.bricks();
    notes->layers = layers.bricks();
  } else {
    notes = nullptr;
  }
  FieldRecords records(cloud, band, nullptr);
  // A renewal would have to measure them again wherever the surface changed nearby.
  if (!settings.renewable) measureBends(samples, records, settings.threads);
  report(1.0);
  return std::make_shared<const SurfaceField>(std::make_shared<const FieldData>(
      cloud, std::move(records), std::move(samples), std::move(notes)));
}

// Repeats each step on the voxels that a change can reach:
//   fits     the 3x3x3 block holds a changed voxel
//   edges    a face within 3 voxels changed in an earlier pass; ends where nothing changes
//   samples  pieces changed in the voxel, or an edge beside it, or a sliver assigned to it
//   vectors  C, or the surface that it is compared with, holds a voxel that changed
//   band     a voxel inherits from one where pieces changed
// Edge searches that a budget leaves wait in a queue (edge_queue.h).
// All other voxels would read the same input and yield the same bits. Records and samples are
// copied whole, because queries need each in one block of memory.
std::shared_ptr<const SurfaceField> renewed(const std::shared_ptr<const SurfaceField>& before,
                                            const Cloud& after, const FieldSettings& settings) {
  validate(before.get(), after);
  const FieldData& old = before->data();
  if (!old.notes()) {
    FieldSettings again = settings;
    again.renewable = true;
    return SurfaceField::build(after, again);
  }
  Known known(*old.notes(), after);
  const VoxelSet cut = changedVoxels(old.cloud(), after, known.emptied);
  FieldDraft draft(after, settings.threads, settings.spend, known.bricks);
  draft.spend(kRenewalCost + kDropCost * known.drops);
  VoxelSet refitted = cut.dilated(1);
  refitted.add(known.rim);
  const VoxelSet changed = renewEdges(draft, known.edges, known.bricks, refitted,
                                      renewFits(draft, refitted), settings.edgeSearches);
  draft.compact();
  if (draft.surfaceBricks().empty())
    throw std::invalid_argument("renewed: no surface is left of the body");
  const VoxelSet recut = recutVoxels(draft, known.bricks, changed);
  VoxelSet turned = turnedVoxels(old.cloud(), after, cut);
  turned.add(known.rim);
  // A sliver depends on the pieces beside it, a voxel's samples on the slivers beside it, and their
  // vectors on all that C and its mirror reach.
  VoxelSet sampled = recut.dilated(2);
  sampled.add(turned.dilated(1));
  VoxelSet seen = changed;
  seen.add(cut);
  sampled.add(seen.dilated(kVectorReach));
  auto notes = std::make_shared<FieldNotes>(draft.cloud.bricks());
  std::vector<CutSample> fresh = cutSamples(draft, &sampled);
  giveBaseVectors(draft, fresh);
  sampled.add(known.dropped);
  SampleSet samples =
      renewSamples(old.samples(), old.notes()->origins, sampled, std::move(fresh), notes->origins);
  draft.spend(kCopyCost * static_cast<double>(samples.levels[0].samples.size()));
  FieldLayers layers(draft, std::move(known.layers));
  VoxelSet reached = layers.renew(recut, turned);
  reached.add(cut);
  reached.add(known.dropped);
  const Band band = renewBand(draft, layers, reached,
                              [&](std::size_t brick) { return old.records().bandBrick(brick); });
  draft.spend(kStoreCost * static_cast<double>(samples.levels[0].samples.size()));
  notes->layers = layers.bricks();
  notes->bricks = draft.bricks();
  notes->edges = std::move(known.edges);
  return std::make_shared<const SurfaceField>(
      std::make_shared<const FieldData>(after, band, std::move(samples), std::move(notes), old));
}

const Cloud& SurfaceField::cloud() const {
  return data_->cloud();
}
std::size_t SurfaceField::bandVoxels() const {
  return data_->records().bandVoxels();
}
std::size_t SurfaceField::bytes() const {
  return data_->bytes();
}
std::size_t SurfaceField::sampleCount() const {
  return data_->samples().levels[0].samples.size();
}
SurfaceSample SurfaceField::sample(std::size_t k) const {
  return data_->samples().levels[0].samples[k];
}
Eigen::AlignedBox3d SurfaceField::bounds() const {
  return data_->bounds();
}
std::size_t SurfaceField::unsettled() const {
  return data_->notes() ? data_->notes()->edges.voxels() : 0;
}
std::uint64_t SurfaceField::hash() const {
  return data_->hash();
}

std::optional<FieldPoint> SurfaceField::at(const Vec3& local) const {
  const Cloud& cloud = data_->cloud();
  const Vec3 g = (local - cloud.origin()) / cloud.voxelSize();
  if (!(g.array().abs() < 32767.0).all()) return std::nullopt;
  const Eigen::Vector3i v = g.array().floor().cast<int>();
  const CcVoxel record = data_->records().at(v.x(), v.y(), v.z());
  if (ccPlaneCount(record) == 0) return std::nullopt;
  const Vec3 r = g - v.cast<double>() - Vec3::Constant(0.5);
  const float x[3] = {float(r.x()), float(r.y()), float(r.z())};
  const CcDepth d = ccVoxelDepth(record, data_->planes(), x);
  return FieldPoint{d.depth * cloud.voxelSize(), Vec3(d.normal[0], d.normal[1], d.normal[2])};
}

std::shared_ptr<const SurfaceField> scaled(const SurfaceField& field, double factor) {
  const FieldData& data = field.data();
  return std::make_shared<const SurfaceField>(std::make_shared<const FieldData>(
      data.cloud().scaled(factor), data.records(), data.samples()));
}

}  // namespace cloudcontact
