// Voxels that count, in columns, those of a patch together, and their sums.
#include <algorithm>
#include <cmath>

#include "base/simd.h"
#include "contact/sixteen.h"
#include "contact/voxel_sums.h"

namespace cloudcontact {

namespace {

using search::V3;

double sumOf(const double* lanes) {
  double sum = 0;
  for (int k = 0; k < 8; ++k) sum += lanes[k];
  return sum;
}
Vec3 vec(const double (*v)[8]) {
  return {sumOf(v[0]), sumOf(v[1]), sumOf(v[2])};
}

}  // namespace

// Finds the places of the first `counted` of lanes.wet in the columns.
void VoxelSums::sortByPatch(int counted) {
  segmentCount_ = 0;
  for (int k = 0; k < counted; ++k) {
    const std::uint32_t patch = patches_[lanes_.wet[k]];
    if (next_[patch]++ == 0) segments_[segmentCount_++].patch = patch;
  }
  int at = 0;
  for (int s = 0; s < segmentCount_; ++s) {
    Segment& segment = segments_[s];
    segment.first = at;
    segment.last = at + next_[segment.patch];
    at = search::padded(segment.last);
    std::fill(columns_.share + segment.last, columns_.share + at, 0.0f);
    std::fill(columns_.weight + segment.last, columns_.weight + at, 0.0f);
    next_[segment.patch] = segment.first;
  }
  for (int k = 0; k < counted; ++k) place_[k] = next_[patches_[lanes_.wet[k]]]++;
  for (int s = 0; s < segmentCount_; ++s) next_[segments_[s].patch] = 0;
}

// Puts the lanes' voxels into the columns.
void VoxelSums::put(int counted) {
  Columns& c = columns_;
  const float weight = static_cast<float>(ccWeightOf(1, hardness_[0], ability_));
  const OwnedVectors::Level* const f =
      vectors_ ? &vectors_->levels[static_cast<std::size_t>(dir_->level)] : nullptr;
  for (int k = 0; k < counted; ++k) {
    const int i = lanes_.wet[k], at = place_[k];
    const std::uint32_t v = voxel_[i];
    c.share[at] = share_[i];
    c.weight[at] = weight * share_[i];
    c.x[at] = lanes_.own.x[i], c.y[at] = lanes_.own.y[i], c.z[at] = lanes_.own.z[i];
    c.fx[at] = f ? f->x[v] : 0, c.fy[at] = f ? f->y[v] : 0, c.fz[at] = f ? f->z[v] : 0;
    c.length[at] = f ? f->length[v] : 0;
  }
}

// The same of what tissues and parts of the other say.
void VoxelSums::weigh(int counted) {
  Columns& c = columns_;
  const double h = own_->field->cloud().voxelSize();
  for (int k = 0; k < counted; ++k) {
    const int at = place_[k];
    const std::uint8_t material = level_->voxels[voxel_[lanes_.wet[k]]].material();
    if (tissues_) {
      const Tissue& tissue = (*own_->tissues)[material];
      c.stiffness[at] = static_cast<float>(tissue.stiffness);
      c.damping[at] = static_cast<float>(tissue.damping);
    }
    double ability = ability_;
    if (parts_)
      ability = abilityAt(ability_, *parts_, toOther_.toWorld(h * Vec3(c.x[at], c.y[at], c.z[at])));
    const double hardness = hardness_.size() > 1 ? hardness_[material] : hardness_[0];
    c.weight[at] = static_cast<float>(ccWeightOf(c.share[at], hardness, ability));
  }
}

// Adds the columns to their patches' sums.
void VoxelSums::sumUp() {
  for (int s = 0; s < segmentCount_; ++s) {
    Sum& sum = sums_[segments_[s].patch];
    addTo(sum.hard, columns_.weight, segments_[s]);
    if (mixed_) addTo(sum.plain, columns_.share, segments_[s]);
  }
}

// Sixteen voxels at once, in a fixed order.
CC_LANES void VoxelSums::addTo(Lanes8* to, const float* weights, const Segment& segment) const {
  const Columns& c = columns_;
  const bool tissues = tissues_;
  Sixteen sum[kTerms] = {};
  for (int i = segment.first; i < segment.last; i += kAtOnce) {
    Sixteen share, w, x, y, z, fx, fy, fz, length, stiffness, damping;
    load(c.share + i, share), load(weights + i, w);
    load(c.x + i, x), load(c.y + i, y), load(c.z + i, z);
    load(c.fx + i, fx), load(c.fy + i, fy), load(c.fz + i, fz);
    load(c.length + i, length);
    const Sixteen wx = w * fx, wy = w * fy, wz = w * fz;
    sum[kCount] += share;
    sum[kWeight] += w, sum[kLength] += w * length;
    sum[kVector] += wx, sum[kVector + 1] += wy, sum[kVector + 2] += wz;
    sum[kMoment] += y * wz - z * wy;
    sum[kMoment + 1] += z * wx - x * wz;
    sum[kMoment + 2] += x * wy - y * wx;
    if (!tissues) continue;
    load(c.stiffness + i, stiffness), load(c.damping + i, damping);
    sum[kStiffness] += share * stiffness;
    sum[kDamping] += share * damping;
  }
  for (int k = 0; k < kTerms; ++k)
    for (int lane = 0; lane < 8; ++lane)
      to[k][lane] += double(sum[k][lane]) + double(sum[k][lane + 8]);
}

// Adds a voxel of that share.
void VoxelSums::addOne(std::size_t patch, double share, const VoxelIndex& v) {
  const Cloud& cloud = own_->field->cloud();
  const double h = cloud.voxelSize();
  const Vec3 center = v.cast<double>() + Vec3::Constant(0.5);
  const std::uint8_t material = cloud.material(v.x(), v.y(), v.z());
  Vec3 f = Vec3::Zero();
  if (vectors_) f = own_->paper->vectors->at(v).toRepresentative / h;
  const double ability =
      parts_ ? abilityAt(ability_, *parts_, toOther_.toWorld(h * center)) : ability_;
  const double hardness = hardness_.size() > 1 ? hardness_[material] : hardness_[0];
  const double weight = ccWeightOf(share, hardness, ability);
  const auto add = [&](Lanes8* sum, double w) {
    const Vec3 moment = center.cross(w * f);
    sum[kCount][0] += share;
    sum[kWeight][0] += w, sum[kLength][0] += w * f.norm();
    for (int k = 0; k < 3; ++k) sum[kVector + k][0] += w * f[k], sum[kMoment + k][0] += moment[k];
    if (!tissues_) return;
    sum[kStiffness][0] += share * (*own_->tissues)[material].stiffness;
    sum[kDamping][0] += share * (*own_->tissues)[material].damping;
  };
  add(sums_[patch].hard, weight);
  if (mixed_) add(sums_[patch].plain, share);
}

void VoxelSums::finish(std::vector<PatchMatter>& matter) {
  lookAtPending();
  flush();
  double weight = 0;
  for (const Sum& sum : sums_) weight += sumOf(sum.hard[kWeight]);
  // (5), where nothing that is touched has a hardness.
  const bool plain = mixed_ && !(weight > 0);
  const int side = dir_->side;
  const double h = own_->field->cloud().voxelSize(), sign = side == kA ? 1 : -1;
  const Eigen::Matrix3d turn = toFrame_.orientation.toRotationMatrix();
  for (std::size_t k = 0; k < sums_.size(); ++k) {
    const Lanes8* const from = plain ? sums_[k].plain : sums_[k].hard;
    PatchMatter& to = matter[k];
    const double count = sumOf(from[kCount]);
    to.count[side] += count;
    if (tissues_) {
      to.stiffness[side] += sumOf(from[kStiffness]);
      to.damping[side] += sumOf(from[kDamping]);
    } else if (own_->tissues) {
      to.stiffness[side] += count * own_->tissues->front().stiffness;
      to.damping[side] += count * own_->tissues->front().damping;
    }
    const Vec3 f = sign * h * turn * vec(from + kVector);
    to.vectors += f;
    to.moment += sign * h * h * turn * vec(from + kMoment) + toFrame_.position.cross(f);
    to.lengths += h * sumOf(from[kLength]);
  }
}

}  // namespace cloudcontact
