// When lists are valid, and when they are worth making.
#include "contact/verlet_lists.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

constexpr double kSteps = 10;                         // for which a skin should last
constexpr double kLeastSkin = 0.03, kMostSkin = 0.1;  // [voxels] a wider one leaves too little out
constexpr double kMostTurn = 0.01;                    // [rad] by which normals may turn

double turned(const CcWay& from, const CcWay& to) {
  double sum = 0;
  for (int i = 0; i < 9; ++i) {
    const double d = to.turnToOther[i] - from.turnToOther[i];
    sum += d * d;
  }
  return std::sqrt(sum);
}

}  // namespace

VerletLists::Ball VerletLists::ballOf(const SampleBricks& bricks) {
  Eigen::AlignedBox3d box;
  const std::size_t count = bricks.runs.size();
  for (std::size_t i = 0; i < count; ++i) box.extend(Vec3(bricks.x[i], bricks.y[i], bricks.z[i]));
  Ball ball;
  if (count == 0) return ball;
  const Vec3 center = box.center();
  for (std::size_t i = 0; i < count; ++i)
    ball.radius =
        std::max(ball.radius,
                 (Vec3(bricks.x[i], bricks.y[i], bricks.z[i]) - center).norm() + bricks.radius[i]);
  std::copy_n(center.data(), 3, ball.center);
  return ball;
}

// A bound on how far samples have moved [the other's voxels]: the ball's center, plus the rotation
// about it. The difference of two rotations stretches no vector by more than its Frobenius norm
// over root two.
double VerletLists::moved(const CcWay& from, const CcWay& to, const Ball& ball) {
  double square = 0, shift = 0;
  for (int i = 0; i < 3; ++i) {
    double d = static_cast<double>(to.toOther.shift[i]) - from.toOther.shift[i];
    for (int j = 0; j < 3; ++j) {
      const double t =
          static_cast<double>(to.toOther.turn[3 * i + j]) - from.toOther.turn[3 * i + j];
      d += t * ball.center[j];
      square += t * t;
    }
    shift += d * d;
  }
  return std::sqrt(shift) + std::sqrt(0.5 * square) * ball.radius;
}

// A pair of fields seen for the first time.
void VerletLists::meet(const FieldData& a, const FieldData& b) {
  const FieldData* const fields[2] = {&a, &b};
  for (int side = 0; side < 2; ++side) {
    lives_[side] = fields[side]->life();
    balls_[side] = ballOf(fields[side]->samples().bricks);
  }
  known_ = made_ = false;
}

bool VerletLists::valid(const CcWay* ways) const {
  if (!made_) return false;
  for (int side = 0; side < 2; ++side)
    if (!(moved(lists_[side].way, ways[side], balls_[side]) <= lists_[side].skin) ||
        !(turned(lists_[side].way, ways[side]) <= kMostTurn))
      return false;
  return true;
}

bool VerletLists::begin(const FieldData& a, const FieldData& b, const CcWay* ways) {
  if (lives_[0] != a.life() || lives_[1] != b.life()) meet(a, b);
  wanted_ = known_;
  for (int side = 0; side < 2; ++side) {
    const double skin = kSteps * moved(last_[side], ways[side], balls_[side]);
    wanted_ = wanted_ && skin <= kMostSkin;
    skins_[side] = static_cast<float>(std::max(skin, kLeastSkin));
    last_[side] = ways[side];
  }
  known_ = true;
  made_ = valid(ways);
  return made_;
}

void VerletLists::reserve(std::size_t ofA, std::size_t ofB) {
  for (int side = 0; side < 2; ++side) {
    const std::size_t lookups = side == 0 ? ofA : ofB;
    std::vector<std::uint32_t>& samples = lists_[side].samples;
    if (samples.capacity() < lookups / 2) samples.reserve(lookups / 4 * 3);
  }
}

void VerletLists::make(const FieldData& a, const FieldData& b, int level,
                       VerletListBuilder& builder) {
  level_ = level;
  const FieldData* const fields[2] = {&a, &b};
  made_ = true;
  for (int side = 0; side < 2; ++side) {
    VerletList& list = lists_[side];
    list.way = last_[side];
    list.skin = skins_[side];
    const VerletListBuilder::Limits limits{level, static_cast<float>(kMostTurn)};
    made_ = made_ && builder.build(*fields[side], *fields[1 - side], limits, list);
  }
}

}  // namespace cloudcontact
