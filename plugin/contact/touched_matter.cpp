// One pass over the collision voxels of both bodies.
#include "contact/touched_matter.h"

#include <cloudcontact/contact/paper_body.h>

#include <cmath>

#include "field/base_vector_bricks.h"

namespace cloudcontact {

namespace {

constexpr double kBesideHits = 2;  // [voxels] collision voxels lie this near to a sample's piece

const PlacedSolid* areaOf(const ContactBody& body, bool vectors) {
  return vectors && body.paper && body.paper->area ? &*body.paper->area : nullptr;
}

const Tissue& tissueOf(const TissueTable& tissues, const Cloud& cloud, const VoxelIndex& v) {
  if (tissues.size() == 1) return tissues[0];
  return tissues[cloud.material(v.x(), v.y(), v.z())];
}

// A body's base vectors, turned into the pair's frame.
class VectorReader {
 public:
  VectorReader(const ContactBody& own, const ContactBody& other, const PairFrame& frame)
      : bricks_(own.paper->vectors->bricks()),
        tool_(other.paper && (other.paper->ability != 1 || !other.paper->parts.empty())
                  ? other.paper
                  : nullptr),
        hardness_(hardnessOf(bricks_.tissues, own.paper->hardness)),
        turn_((frame.pose.orientation.conjugate() * own.pose.orientation).toRotationMatrix()),
        toTool_(other.pose.inverse() * frame.pose) {}

  // Share, hardness and ability times f_j [m].
  Vec3 at(const TouchedVoxel& v) const {
    const FieldBlock* const block = bricks_.blockOf(v.voxel);
    if (!block) return Vec3::Zero();
    const int cell = cellIndex(v.voxel);
    const double h = hardness_[block->tissue[static_cast<std::size_t>(cell)]];
    const double ability = tool_ ? abilityAt(*tool_, toTool_.toWorld(v.at)) : 1;
    return v.share * h * ability * bricks_.voxelSize *
           (turn_ * bricks_.weigh(*block, cell).toRepresentative);
  }

 private:
  const BaseVectorBricks& bricks_;
  const PaperBody* tool_;  // null if it cuts alike everywhere
  std::vector<double> hardness_;
  Eigen::Matrix3d turn_;
  Pose toTool_;  // from the frame
};

}  // namespace

void PatchMatter::add(const PatchMatter& other, double share) {
  for (int s = 0; s < 2; ++s) {
    count[s] += share * other.count[s];
    stiffness[s] += share * other.stiffness[s];
    damping[s] += share * other.damping[s];
  }
  vectors += share * other.vectors;
  moment += share * other.moment;
  lengths += share * other.lengths;
}

bool TouchedMatter::wanted(const ContactBody& a, const ContactBody& b,
                           const ContactSettings& settings) {
  return a.tissues || b.tissues || settings.normals == Normals::BaseVectors;
}

void TouchedMatter::addBody(const ContactBody& own, const ContactBody& other, Side side,
                            bool vectors, const PairFrame& frame, const FoundHits& found,
                            double reach) {
  const Cloud& cloud = own.field->cloud();
  std::optional<VectorReader> reader;
  if (vectors) reader.emplace(own, other, frame);
  const TouchedVoxels voxels(own, other, frame, areaOf(other, vectors), found.gap);
  work_.voxels += voxels.each(found.hits, reach, near_, [&](const TouchedVoxel& v) {
    const int patch = map_.of(v.at, 1 - side, v.other);
    PatchMatter& to = patch < 0 ? rest_ : matter_[static_cast<std::size_t>(patch)];
    to.count[side] += v.share;
    if (own.tissues) {
      const Tissue& tissue = tissueOf(*own.tissues, cloud, v.voxel);
      to.stiffness[side] += v.share * tissue.stiffness;
      to.damping[side] += v.share * tissue.damping;
    }
    if (!reader) return;
    const Vec3 f = (side == kA ? 1 : -1) * reader->at(v);
    to.vectors += f;
    to.moment += v.at.cross(f);
    to.lengths += f.norm();
  });
}

// Voxels near no bin, deep inside a body, belong to all patches.
void TouchedMatter::shareRest() {
  double all = 0;
  for (const PatchMatter& m : matter_) all += m.count[0] + m.count[1];
  if (!(all > 0)) return;
  for (PatchMatter& m : matter_) m.add(rest_, (m.count[0] + m.count[1]) / all);
}

std::span<const PatchMatter> TouchedMatter::of(const ContactBody& a, const ContactBody& b,
                                               const ContactSettings& settings,
                                               const PairFrame& frame, const FoundHits& found) {
  matter_.assign(found.patches, {});
  rest_ = {};
  if (found.hits.empty()) return matter_;
  map_.read(found.bins, found.cell);
  const double reach = ((1 << found.level) + kBesideHits) * frame.voxel;
  const bool vectors = settings.normals == Normals::BaseVectors;
  if (a.field && (vectors || a.tissues)) addBody(a, b, kA, vectors, frame, found, reach);
  if (b.field && (vectors || b.tissues)) addBody(b, a, kB, vectors, frame, found, reach);
  shareRest();
  return matter_;
}

KelvinVoigt springOf(const PatchMatter& matter, const ContactBody& a, const ContactBody& b) {
  const auto of = [&](const ContactBody& body, int side) -> std::optional<KelvinVoigt> {
    if (!body.tissues) return body.spring;
    const double n = matter.count[side];
    const Tissue& first = body.tissues->front();
    if (!(n > 0)) return KelvinVoigt{first.stiffness, first.damping};
    return KelvinVoigt{matter.stiffness[side] / n, matter.damping[side] / n};
  };
  return inSeries(of(a, kA), of(b, kB)).value_or(KelvinVoigt{});
}

}  // namespace cloudcontact
