// The nearest bin first; then those whose cells are near enough. Of a bin, what is surely too far
// away is found for all hits at once.
#include "contact/patch_hits.h"

#include "base/simd.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cloudcontact {

namespace {

// Numbers in float are less exact, so a little more is looked at: of a square, and in cells.
constexpr float kLessByRounding = 0.9999F;
constexpr double kMore = 1e-3;

// The line of a CcNearestHit, in float.
struct Line {
  float px, py, pz, nx, ny, nz;
  float reach, largest, more;
};

Line lineOf(const CcNearestHit& best, double cell) {
  return {float(best.place.x),  float(best.place.y),      float(best.place.z),
          float(best.normal.x), float(best.normal.y),     float(best.normal.z),
          float(best.reach),    float(CC_LARGEST * cell), float(kMore * cell)};
}

constexpr std::uint32_t kBlock = 16;  // hits

// For each of some hits, the square of ccTryHit(), or less. After them `least` has room for as many
// as make blocks whole.
CC_LANES void leastOf(const Line& to, const float* xs, const float* ys, const float* zs,
                      const float* widths, std::uint32_t count, float* least) {
  const Line line = to;
  CC_INDEPENDENT
  for (std::uint32_t k = 0; k < count; ++k) {
    const float x = xs[k] - line.px, y = ys[k] - line.py, z = zs[k] - line.pz;
    const float along = x * line.nx + y * line.ny + z * line.nz;
    const float square = std::max(0.0F, (x * x + y * y + z * z) - along * along);
    const float away = std::max(0.0F, std::sqrt(square) - line.more);
    const float beside = std::max(0.0F, away - std::min(line.reach * widths[k], line.largest));
    least[k] = kLessByRounding * (beside * beside + float(CC_MIDDLES) * (away * away));
  }
}

// The least of each block.
CC_LANES void leastOfBlocks(const float* least, std::uint32_t blocks, float* of) {
  for (std::uint32_t b = 0; b < blocks; ++b) {
    const float* const from = least + kBlock * b;
    float half[kBlock / 2];
    for (std::uint32_t k = 0; k < kBlock / 2; ++k) half[k] = ccMin(from[k], from[k + kBlock / 2]);
    float most = half[0];
    for (std::uint32_t k = 1; k < kBlock / 2; ++k) most = ccMin(most, half[k]);
    of[b] = most;
  }
}

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
      if (ccGate(c.facing[i], c.depth[i]) < CC_LEAST_GATE) continue;
      x_.push_back(c.x[i]), y_.push_back(c.y[i]), z_.push_back(c.z[i]);
      width_.push_back(std::sqrt(c.area[i]));
      index_.push_back(i);
    }
    const auto end = static_cast<std::uint32_t>(index_.size());
    bins_.push_back({ccVecAt(pair.binner->sums(bin).origin), ballAround(begin, end), begin, end});
  }
  least_.resize(std::max(least_.size(), index_.size() + kBlock));
  leastOfBlock_.resize(std::max(leastOfBlock_.size(), least_.size() / kBlock));
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

// Whether a bin may have a nearer hit.
bool PatchHits::mayBeNearer(const Bin& bin, const CcNearestHit& best) const {
  const double most = best.nearest + bin.ball.radius + best.reach * bin.ball.width + kMore * cell_;
  return ccSquareAside(ccMinus(bin.ball.center, best.place), best.normal) < most * most;
}

void PatchHits::reserveLike(const PatchHits& other) {
  bins_.reserve(other.bins_.capacity());
  for (std::vector<float>* column : {&x_, &y_, &z_, &width_}) column->reserve(other.x_.capacity());
  index_.reserve(other.index_.capacity());
  least_.reserve(other.least_.capacity());
  leastOfBlock_.reserve(other.leastOfBlock_.capacity());
}

void PatchHits::tryHit(std::uint32_t hit, CcNearestHit& best) const {
  const HitColumns::Columns<const float> c = hits_->columns();
  const std::uint32_t i = index_[hit];
  ++work_.tried;
  const float at[3] = {c.x[i], c.y[i], c.z[i]}, own[3] = {c.ownX[i], c.ownY[i], c.ownZ[i]},
              other[3] = {c.otherX[i], c.otherY[i], c.otherZ[i]};
  ccTryHit(&best, cell_, at, own, other, c.facing[i], c.depth[i], c.area[i], hits_->side(i));
}

// All are tried in their order, since the first of equals counts; but only those that may be nearer
// than the one that promises most.
void PatchHits::tryBin(const Bin& bin, CcNearestHit& best) const {
  const std::uint32_t count = bin.end - bin.begin;
  if (count == 0) return;
  work_.scanned += count;
  float* const least = least_.data();
  leastOf(lineOf(best, cell_), &x_[bin.begin], &y_[bin.begin], &z_[bin.begin], &width_[bin.begin],
          count, least);
  const std::uint32_t blocks = (count + kBlock - 1) / kBlock;
  std::fill(least + count, least + kBlock * blocks, std::numeric_limits<float>::infinity());
  float* const ofBlock = leastOfBlock_.data();
  leastOfBlocks(least, blocks, ofBlock);
  const float* const block = std::min_element(ofBlock, ofBlock + blocks);
  if (!(double(*block) < best.square)) return;
  const float* const nearest = std::find(least + kBlock * (block - ofBlock), least + count, *block);
  CcNearestHit promised = best;
  tryHit(bin.begin + static_cast<std::uint32_t>(nearest - least), promised);
  for (std::uint32_t b = 0; b < blocks; ++b) {
    if (!(double(ofBlock[b]) <= promised.square)) continue;
    for (std::uint32_t k = kBlock * b; k < std::min(count, kBlock * (b + 1)); ++k)
      if (double(least[k]) <= promised.square) tryHit(bin.begin + k, best);
  }
}

float PatchHits::largestOf(const std::vector<float>& numbers) const {
  float largest = 0;
  for (const std::uint32_t i : index_) largest = std::max(largest, numbers[i]);
  return largest;
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
      if (round == CC_WET_ROUNDS || !ccMayMove(&plan, &found[i])) continue;
      const CcNearestHit mirrored = nearest(ccMirrored(&found[i]));
      found[i].moves = ccMoves(&mirrored, plan.voxel);
    }
    if (round == CC_WET_ROUNDS || !ccMoveToWet(&plan, &flat, found)) return;
  }
}

}  // namespace cloudcontact
