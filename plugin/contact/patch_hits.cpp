// The nearest bin first; then those whose cells are near enough. Of a bin, what is surely too far
// away is found for all hits at once.
#include "contact/patch_hits.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cloudcontact {

namespace {

constexpr std::uint32_t kAtOnce = 32;
// Numbers in float are less exact, so a little more is looked at: of a square, and in cells.
constexpr float kRounding = 0.9999F;
constexpr double kMore = 1e-3;

}  // namespace

void PatchHits::take(const PairHits& pair, std::size_t patch) {
  hits_ = pair.hits;
  cell_ = pair.cell;
  bins_.clear();
  x_.clear(), y_.clear(), z_.clear(), width_.clear(), index_.clear();
  const HitColumns::Columns<const float> c = hits_->columns();
  for (const std::uint32_t bin : pair.binner->binsOf(patch)) {
    const auto begin = static_cast<std::uint32_t>(index_.size());
    for (const std::uint32_t i : pair.binner->hitsOf(bin)) {
      if (ccGate(c.facing[i]) < CC_LEAST_GATE) continue;
      x_.push_back(c.x[i]), y_.push_back(c.y[i]), z_.push_back(c.z[i]);
      width_.push_back(std::sqrt(c.area[i]));
      index_.push_back(i);
    }
    const auto end = static_cast<std::uint32_t>(index_.size());
    bins_.push_back({ccVecAt(pair.binner->sums(bin).origin), ballAround(begin, end), begin, end});
  }
}

PatchHits::Ball PatchHits::ballAround(std::uint32_t begin, std::uint32_t end) const {
  Eigen::AlignedBox3d box;
  double width = 0;
  for (std::uint32_t k = begin; k < end; ++k) {
    box.extend(Vec3(x_[k], y_[k], z_[k]));
    width = std::max(width, double(width_[k]));
  }
  if (begin == end) return {ccVec(0, 0, 0), 0, 0};
  const Vec3 center = box.center();
  return {ccVec(center.x(), center.y(), center.z()), (0.5 + kMore) * box.diagonal().norm(), width};
}

// Whether a bin may have a nearer hit; ccMayBeNearer() with less left over.
bool PatchHits::mayBeNearer(const Bin& bin, const CcNearestHit& best) const {
  const double most = best.nearest + bin.ball.radius + best.reach * bin.ball.width + kMore * cell_;
  return ccSquareAside(ccMinus(bin.ball.center, best.place), best.normal) < most * most;
}

void PatchHits::reserveLike(const PatchHits& other) {
  bins_.reserve(other.bins_.capacity());
  for (std::vector<float>* column : {&x_, &y_, &z_, &width_}) column->reserve(other.x_.capacity());
  index_.reserve(other.index_.capacity());
}

void PatchHits::tryBin(const Bin& bin, CcNearestHit& best) const {
  const HitColumns::Columns<const float> c = hits_->columns();
  const auto px = float(best.place.x), py = float(best.place.y), pz = float(best.place.z);
  const auto nx = float(best.normal.x), ny = float(best.normal.y), nz = float(best.normal.z);
  const auto reach = float(best.reach), largest = float(CC_LARGEST * cell_);
  const auto more = float(kMore * cell_);
  for (std::uint32_t first = bin.begin; first < bin.end; first += kAtOnce) {
    const std::uint32_t count = std::min(kAtOnce, bin.end - first);
    float least[kAtOnce];  // of ccTryHit(), or less
    for (std::uint32_t k = 0; k < count; ++k) {
      const float x = x_[first + k] - px, y = y_[first + k] - py, z = z_[first + k] - pz;
      const float along = x * nx + y * ny + z * nz;
      const float square = std::max(0.0F, (x * x + y * y + z * z) - along * along);
      const float away = std::max(0.0F, std::sqrt(square) - more);
      const float beside = std::max(0.0F, away - std::min(reach * width_[first + k], largest));
      least[k] = kRounding * (beside * beside + float(CC_MIDDLES) * (away * away));
    }
    for (std::uint32_t k = 0; k < count; ++k) {
      if (!(double(least[k]) < best.square)) continue;
      const std::uint32_t i = index_[first + k];
      const float at[3] = {c.x[i], c.y[i], c.z[i]}, own[3] = {c.ownX[i], c.ownY[i], c.ownZ[i]},
                  other[3] = {c.otherX[i], c.otherY[i], c.otherZ[i]};
      ccTryHit(&best, cell_, at, own, other, c.facing[i], c.area[i], hits_->side(i));
    }
  }
}

CcNearestHit PatchHits::nearest(CcNearestHit best) const {
  const Bin* first = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const Bin& bin : bins_) {
    const double square = ccSquareTo(&best, bin.middle);
    if (square < least) least = square, first = &bin;
  }
  if (first) tryBin(*first, best);
  for (const Bin& bin : bins_)
    if (&bin != first && mayBeNearer(bin, best)) tryBin(bin, best);
  return best;
}

void PatchHits::place(const CcPatchForce& force, const CcFlat& flat, CcPlan& plan,
                      CcNearestHit* found) const {
  for (int round = 0; round <= CC_WET_ROUNDS; ++round) {
    for (int i = 0; i < 4; ++i) {
      found[i] = nearest(ccNoHit(ccPlannedPlace(&plan, &force, &flat, i),
                                 ccPlannedNormal(&plan, &flat, i), CC_COVERS, CC_ABOVE));
      if (!ccIsBeside(&found[i], plan.voxel)) continue;
      const CcNearestHit mirrored = nearest(ccMirrored(&found[i]));
      found[i].moves = ccMoves(&mirrored, plan.voxel);
    }
    if (round == CC_WET_ROUNDS || !ccMoveToWet(&plan, &flat, found)) return;
  }
}

}  // namespace cloudcontact
