// Levels by the surfaces' errors where the bodies may meet, capped by the contact's own.
#include "bullet/pair_levels.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

constexpr double kBackShare = 0.7;  // of the tolerance, for a level coarser than the last step's
constexpr double kCalm = 0.5;       // of the tolerance; with voxels twice as large, noise is ...
constexpr double kGrowth = 4;       // ... larger by the voxel and by the fewer hits
// Light touches that pass have few hits and a large error: finer fields are not built for them.
constexpr double kFar = 4;      // times the tolerance is too much at once
constexpr int kHot = 8;         // searches in a row with too much
constexpr double kOfGap = 0.5;  // a gap may be wrong by this much of itself
constexpr double kHeld = 0.6;   // patches that push together by less hold a body

double toleranceOf(const CloudShape& cloud, double world) {
  return cloud.fidelity().tolerance > 0 ? cloud.fidelity().tolerance : world;
}

// Where what is near the other body may be, in this one's frame; the whole of this one beside no
// cloud.
Eigen::AlignedBox3d regionOf(const CloudShape* const clouds[2], const Pose poses[2], int side,
                             double reach) {
  const CloudShape* const other = clouds[1 - side];
  if (!other) return clouds[side]->bounds();
  const Pose toThis = poses[side].inverse() * poses[1 - side];
  const Eigen::AlignedBox3d box = other->bounds();
  const Vec3 half = toThis.orientation.toRotationMatrix().cwiseAbs() * (0.5 * box.sizes()) +
                    Vec3::Constant(reach);
  const Vec3 middle = toThis.toWorld(box.center());
  return {middle - half, middle + half};
}

// Of patches that hold a body from opposite sides this is small.
double togetherness(const ContactResult& contact) {
  Vec3 sum = Vec3::Zero();
  double all = 0;
  for (const Patch& patch : contact.patches) {
    sum += patch.stiffness * patch.normal;
    all += patch.stiffness;
  }
  return all > 0 ? sum.norm() / all : 1;
}

}  // namespace

double PairLevels::tolerance(const CloudShape* const clouds[2], double world) {
  double least = 0;
  for (int side = 0; side < 2; ++side) {
    const double own = clouds[side] ? toleranceOf(*clouds[side], world) : 0;
    if (own > 0) least = least > 0 ? std::min(least, own) : own;
  }
  return least;
}

LevelChoice PairLevels::choose(const CloudShape* const clouds[2], const Pose poses[2], double world,
                               double reach) const {
  LevelChoice choice;
  choice.tolerance = tolerance(clouds, world);
  const double most = 0.5 * choice.tolerance * sharpness();
  for (int side = 0; side < 2; ++side) {
    if (!clouds[side] || !(toleranceOf(*clouds[side], world) > 0)) continue;
    const FieldLevels& levels = clouds[side]->levels();
    const Eigen::AlignedBox3d region = regionOf(clouds, poses, side, reach);
    int level = levels.count() - 1;
    for (; level > 0; --level) {
      if (levels.voxelSize(level) > cap_) continue;
      const Vec3 around = Vec3::Constant(levels.voxelSize(level));
      const double share = most * (known_ && level > last_.level[side] ? kBackShare : 1);
      const double error = levels.error(level, {region.min() - around, region.max() + around});
      if (error <= share) break;
    }
    const int within = level;
    while (level < within + ease && level + 1 < levels.count() &&
           std::isfinite(levels.error(level + 1, region)))
      ++level;
    choice.level[side] = level;
    choice.error += levels.error(level, region);
    choice.anywhere += levels.error(level);
    choice.eased = std::max(choice.eased, level - within);
  }
  if (choice.isCoarse()) choice.samples = samples_;
  return choice;
}

void PairLevels::apply(const LevelChoice& choice, const CloudShape* const clouds[2],
                       ContactBody* const bodies[2]) {
  for (int side = 0; side < 2; ++side)
    if (clouds[side])
      bodies[side]->field = choice.level[side] > 0
                                ? clouds[side]->levels().field(choice.level[side]).get()
                                : &clouds[side]->field();
}

// A level that did not hold is tried again later and later.
void PairLevels::impatient() {
  if (since_ < 2 * patience_) patience_ = std::min(2 * patience_, kMostPatience);
  since_ = kMostPatience;
}

bool PairLevels::refines(const LevelChoice& choice, const CloudShape* const clouds[2], double error,
                         const ContactResult& contact) {
  if (contact.patches.empty() || !choice.isCoarse()) return false;
  if (!tight_ && contact.patches.size() > 1 && togetherness(contact) < kHeld) {
    tight_ = true;
    loose_ = 0;
    return true;
  }
  // The error of a gap grows with the gap.
  const double bearable =
      std::max(choice.tolerance * sharpness(), kOfGap * std::max(0.0, -depthOf(contact)));
  if (choice.eased > 0 || !(error > bearable)) {
    hot_ = 0;
    return false;
  }
  calm_ = 0;
  if (samples_ < ContactSettings::kSamples) {
    samples_ *= 4;
    impatient();
    return true;
  }
  if (error < kFar * bearable && ++hot_ < kHot) return false;
  hot_ = 0;
  double voxel = 0;
  for (int side = 0; side < 2; ++side) {
    if (!clouds[side] || choice.level[side] == 0) continue;
    const FieldLevels& levels = clouds[side]->levels();
    voxel = std::max(voxel, levels.voxelSize(choice.level[side]));
    coarsest_ = std::max(coarsest_, levels.voxelSize(levels.count() - 1));
  }
  cap_ = 0.5 * voxel;
  impatient();
  samples_ = kFewSamples;
  return true;
}

void PairLevels::learn(const LevelChoice& choice, double error, const ContactResult& contact) {
  known_ = true;
  last_ = choice;
  if (!(choice.tolerance > 0)) return;
  since_ = std::min(since_ + 1, kMostPatience);
  const bool apart = contact.patches.empty();
  if (tight_) {
    loose_ = apart || togetherness(contact) >= kHeld ? loose_ + 1 : 0;
    if (loose_ > patience_) tight_ = false;
  }
  if (cap_ == kNoCap && samples_ == kFewSamples) return;
  calm_ = apart || kGrowth * error < kCalm * choice.tolerance * sharpness() ? calm_ + 1 : 0;
  if (calm_ <= patience_) return;
  calm_ = since_ = 0;
  if (samples_ > kFewSamples) {
    samples_ /= 4;
    return;
  }
  cap_ = 2 * cap_ < coarsest_ ? 2 * cap_ : kNoCap;
}

}  // namespace cloudcontact
