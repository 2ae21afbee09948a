// When lists are valid, and when they are worth making.
#include "contact/verlet_lists.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cloudcontact {

namespace {

constexpr double kSteps = 10;                         // for which a skin should last
constexpr double kLeastSkin = 0.03, kMostSkin = 0.1;  // [voxels] a wider one leaves too little out
constexpr double kMostTurn = 0.01;                    // [rad] by which normals may turn
// Room for a list: of most pairs, less than twice as many samples as are hits may be.
constexpr std::size_t kRoomPerHit = 2, kLeastRoom = 32;

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

// How far normals turn at most while no sample of a ball moves by more than `skin`, as turned() has
// it, and kMostTurn.
float VerletLists::turnWithin(float skin, const CcWay& way, const Ball& ball) {
  double square = 0;
  for (const float t : way.toOther.turn) square += static_cast<double>(t) * t;
  const double perVoxel = std::sqrt(square / 3);  // the other's voxels in one of the samples'
  return static_cast<float>(
      std::min(kMostTurn, 1.01 * std::sqrt(2.0) * skin / (perVoxel * std::max(ball.radius, 1.0))));
}

// How much of what the lists are made for is used up; above 1 they are not valid.
float VerletLists::ageAt(const CcWay* ways) const {
  double age = 0;
  for (int side = 0; side < 2; ++side) {
    const VerletList& list = lists_[side];
    age = std::max(age, moved(list.way, ways[side], balls_[side]) / double(list.skin));
    age = std::max(age, turned(list.way, ways[side]) / double(list.turn));
  }
  return static_cast<float>(age);
}

bool VerletLists::begin(const FieldData& a, const FieldData& b, const CcWay* ways,
                        std::size_t enough) {
  if (lives_[0] != a.life() || lives_[1] != b.life()) meet(a, b);
  wanted_ = known_;
  for (int side = 0; side < 2; ++side) {
    // Of a pair that is also asked where it is at the step's end, every other query moves it
    // little.
    const double motion = known_ ? moved(last_[side], ways[side], balls_[side]) : 0,
                 skin = kSteps * std::max(motion, std::exchange(motions_[side], motion));
    wanted_ = wanted_ && skin <= kMostSkin;
    skins_[side] = static_cast<float>(std::max(skin, kLeastSkin));
    last_[side] = ways[side];
  }
  known_ = true;
  if (made_) age_ = ageAt(ways);
  made_ = made_ && age_ <= 1 && enough == enough_;
  return made_;
}

void VerletLists::reserve(int level, std::size_t ofA, std::size_t ofB) {
  if (!lists_) lists_ = std::make_unique<VerletList[]>(2);
  lists_[kA].reserve(level, spare_ * (kRoomPerHit * ofA + kLeastRoom));
  lists_[kB].reserve(level, spare_ * (kRoomPerHit * ofB + kLeastRoom));
}

std::size_t VerletLists::bytesKept() const {
  return lists_ ? 2 * sizeof(VerletList) + lists_[0].bytes() + lists_[1].bytes() : 0;
}

void VerletLists::make(const FieldData& a, const FieldData& b, int level, std::size_t enough,
                       VerletListBuilder& builder) {
  level_ = level, enough_ = enough;
  const FieldData* const fields[2] = {&a, &b};
  for (int side = 0; side < 2; ++side) {
    lists_[side].way = last_[side], lists_[side].skin = skins_[side];
    lists_[side].turn = turnWithin(skins_[side], last_[side], balls_[side]);
  }
  made_ = builder.build(fields, {level, enough}, lists_.get(), passes_);
  if (!made_) spare_ *= 2;
}

}  // namespace cloudcontact
