// Reading Bullet's rows, and Newton's steps.
#include "bullet/newton_rows.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace cloudcontact {

namespace {

// The least softness, as a part of J M^-1 J^T. What it leaves of a row's error is about the same
// part.
constexpr double kSoftness = 1e-4;
// Steps after which the impulses are left as they are. A heap that is hit takes up to 200.
constexpr int kMostSteps = 400;
// A step of nearly its whole length has reached the least of its quadratic function.
constexpr double kWhole = 0.99;
// What a mean slope keeps from step to step, and what is none, as a part of the row's mass.
constexpr double kFade = 0.25, kNoSlope = 1e-3;
// [steps] Friction's limits that agree as soon as that, if they go on to close in as they do,
// follow the impulses.
constexpr double kSoon = 4;
// Of what friction's limits want, what is left to the next step.
constexpr double kLeft = 0.2;
// Friction's limits that so many followings bring no nearer than by this factor only shrink. A
// method that finds limits and impulses together, from any start, would need neither.
constexpr int kFollowings = 6;
constexpr double kNearer = 0.5;
// The longest step, in whole ones.
constexpr double kLongest = 2;

// How far off friction's limits may be [m/s] that were `before` off the last time, if they come to
// `speed` soon at this rate.
double agreesSoon(double before, double speed) {
  return std::max(speed, std::pow(speed * std::pow(before, kSoon), 1 / (kSoon + 1)));
}

double valueOf(const btSimdScalar& impulse) {
  return static_cast<double>(btScalar(impulse));
}

}  // namespace

// Numbers the bodies that move. Of the inverse inertia, a root is Cholesky's factor; axes about
// which a body does not turn have none.
void NewtonRows::number(const btAlignedObjectArray<btSolverBody>& bodies) {
  moved_.assign(static_cast<std::size_t>(bodies.size()), {});
  bodies_ = 0;
  for (int i = 0; i < bodies.size(); ++i) {
    const btRigidBody* const body = bodies[i].m_originalBody;
    if (!body) continue;
    const btMatrix3x3& inverse = body->getInvInertiaTensorWorld();
    if (bodies[i].internalGetInvMass().isZero() &&
        !(inverse[0][0] + inverse[1][1] + inverse[2][2] > 0))
      continue;
    Moved& moved = moved_[static_cast<std::size_t>(i)];
    moved.number = bodies_++;
    double root[3][3] = {};
    for (int k = 0; k < 3; ++k)
      for (int row = k; row < 3; ++row) {
        double rest = inverse[row][k];
        for (int j = 0; j < k; ++j) rest -= root[row][j] * root[k][j];
        if (row > k)
          root[row][k] = root[k][k] > 0 ? rest / root[k][k] : 0;
        else
          root[k][k] = rest > 1e-12 * double(inverse[k][k]) ? std::sqrt(rest) : 0;
      }
    const double lower[kSize] = {root[0][0], root[1][0], root[2][0],
                                 root[1][1], root[2][1], root[2][2]};
    std::copy(std::begin(lower), std::end(lower), moved.root);
  }
}

// Returns whether it pushes anything.
bool NewtonRows::readRow(const btSolverConstraint& from,
                         const btAlignedObjectArray<btSolverBody>& bodies, Row& row) const {
  const int ids[2] = {from.m_solverBodyIdA, from.m_solverBodyIdB};
  for (int side = 0; side < 2; ++side) {
    const Moved& moved = moved_[static_cast<std::size_t>(ids[side])];
    row.body[side] = moved.number < 0 ? bodies_ : moved.number;
    if (moved.number < 0) continue;
    const btVector3& push = side ? from.m_contactNormal2 : from.m_contactNormal1;
    const btVector3& turn = side ? from.m_relpos2CrossNormal : from.m_relpos1CrossNormal;
    const btVector3& mass = bodies[ids[side]].internalGetInvMass();
    const double t[3] = {double(turn[0]), double(turn[1]), double(turn[2])};
    const double* const root = moved.root;
    double* const of = row.of[side];
    for (int k = 0; k < 3; ++k) of[k] = std::sqrt(double(mass[k])) * double(push[k]);
    of[3] = root[0] * t[0] + root[1] * t[1] + root[2] * t[2];
    of[4] = root[3] * t[1] + root[4] * t[2];
    of[5] = root[5] * t[2];
    for (int k = 0; k < kSize; ++k) row.inverse += of[k] * of[k];
  }
  if (row.body[0] > row.body[1]) {
    std::swap(row.body[0], row.body[1]);
    std::swap(row.of[0], row.of[1]);
  }
  const double scale = from.m_jacDiagABInv;
  if (!(scale > 0) || !(row.inverse > 0)) return false;
  const double soft = double(from.m_cfm) / scale, least = kSoftness * row.inverse;
  row.soft = std::max(soft, least);
  row.unit = 1 / std::sqrt(row.inverse);
  row.free = double(from.m_rhs) / scale + (row.soft - soft) * valueOf(from.m_appliedImpulse);
  row.low = from.m_lowerLimit;
  row.high = from.m_upperLimit;
  return true;
}

// Friction's limits are those of the normal impulses that the rows have.
void NewtonRows::read(const Pools& pools, const btAlignedObjectArray<btSolverBody>& bodies) {
  rows_.clear();
  impulses_.clear();
  const int joints = pools.joints.size();
  firstFriction_ = static_cast<std::size_t>(joints + pools.contacts.size());
  for (const btConstraintArray* pool :
       {&pools.joints, &pools.contacts, &pools.frictions, &pools.rolling})
    for (int i = 0; i < pool->size(); ++i) {
      const btSolverConstraint& from = (*pool)[i];
      Row& row = rows_.emplace_back();
      const bool pushes = readRow(from, bodies, row);
      impulses_.push_back(valueOf(from.m_appliedImpulse));
      if (rows_.size() <= firstFriction_) continue;
      row.normal = joints + from.m_frictionIndex;
      row.friction = pushes ? double(from.m_friction) : 0;
      if (pool == &pools.rolling) row.most = from.m_friction;
      const double normal = impulses_[static_cast<std::size_t>(row.normal)];
      row.high = std::min(row.most, row.friction * std::max(0.0, normal));
      row.low = -row.high;
    }
}

// Rows of a pair mostly follow each other.
void NewtonRows::findPairs() {
  pairs_.clear();
  const auto pairOf = [](const Row& row) { return BlockCholesky::Pair(row.body[0], row.body[1]); };
  for (const Row& row : rows_)
    if (row.body[0] != row.body[1] && row.body[1] < bodies_ &&
        (pairs_.empty() || pairs_.back() != pairOf(row)))
      pairs_.push_back(pairOf(row));
  std::sort(pairs_.begin(), pairs_.end());
  pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
  for (Row& row : rows_)
    if (row.body[0] != row.body[1] && row.body[1] < bodies_)
      row.pair = static_cast<int>(std::lower_bound(pairs_.begin(), pairs_.end(), pairOf(row)) -
                                  pairs_.begin());
}

// The change of velocities by the impulses that the rows have.
void NewtonRows::begin() {
  u_.assign(static_cast<std::size_t>(kSize * (bodies_ + 1)), 0);
  for (std::size_t r = 0; r < rows_.size(); ++r)
    for (int side = 0; side < 2; ++side)
      for (int k = 0; k < kSize; ++k)
        u_[static_cast<std::size_t>(kSize * rows_[r].body[side] + k)] +=
            impulses_[r] * rows_[r].of[side][k];
  std::fill(u_.end() - kSize, u_.end(), 0.0);
  for (Row& row : rows_) {
    row.apart = row.free;
    for (int side = 0; side < 2; ++side)
      for (int k = 0; k < kSize; ++k)
        row.apart -= row.of[side][k] * u_[static_cast<std::size_t>(kSize * row.body[side] + k)];
  }
  matrix_.reset(bodies_, pairs_);
}

// Changes what a row adds to the matrix.
void NewtonRows::weigh(Row& row, double weight) {
  const double change = weight - row.weight;
  row.weight = weight;
  const auto add = [&](BlockCholesky::Block& block, const double* left, const double* right) {
    for (int j = 0; j < kSize; ++j) {
      const double by = change * right[j];
      for (int i = 0; i < kSize; ++i)
        block[static_cast<std::size_t>(kSize * j + i)] += by * left[i];
    }
  };
  for (int side = 0; side < 2; ++side)
    if (row.body[side] < bodies_) add(matrix_.diagonal(row.body[side]), row.of[side], row.of[side]);
  if (row.pair < 0) {
    if (row.body[0] != row.body[1] || row.body[0] >= bodies_) return;
    add(matrix_.diagonal(row.body[0]), row.of[0], row.of[1]);
    return add(matrix_.diagonal(row.body[0]), row.of[1], row.of[0]);
  }
  const auto [block, swapped] = matrix_.beside(static_cast<std::size_t>(row.pair));
  add(block, row.of[swapped], row.of[!swapped]);
}

// Impulses at u, the matrix, and the function's gradient. Which rows are within their limits, the
// impulses say or u does. Returns how many rows' weights changed.
int NewtonRows::classify(bool byImpulses) {
  gradient_ = u_;
  int changed = 0;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    Row& row = rows_[r];
    const double impulse = row.apart / row.soft;
    const double by = byImpulses ? impulses_[r] : impulse;
    row.isWithin = by > row.low && by < row.high;
    impulses_[r] = row.isWithin ? impulse : std::clamp(by, row.low, row.high);
    const double weight = row.isWithin ? 1 / row.soft : row.slope;
    if (weight != row.weight) {
      weigh(row, weight);
      ++changed;
    }
    if (impulses_[r] == 0) continue;
    for (int side = 0; side < 2; ++side) {
      double* const at = &gradient_[static_cast<std::size_t>(kSize * row.body[side])];
      for (int k = 0; k < kSize; ++k) at[k] -= impulses_[r] * row.of[side][k];
    }
  }
  return changed;
}

// How far the bodies' step moves a row [m/s].
[[gnu::always_inline]] inline double NewtonRows::alongStep(const Row& row) const {
  const double *a = &step_[static_cast<std::size_t>(kSize * row.body[0])],
               *b = &step_[static_cast<std::size_t>(kSize * row.body[1])];
  double along = 0;
  for (int k = 0; k < kSize; ++k) along += row.of[0][k] * a[k] + row.of[1][k] * b[k];
  return along;
}

// Newton's step, and how far it moves each row. Returns the largest [m/s].
double NewtonRows::measureStep() {
  step_ = gradient_;
  for (double& x : step_) x = -x;
  std::fill(step_.end() - kSize, step_.end(), 0.0);
  matrix_.solve(step_.data());
  double most = 0;
  for (Row& row : rows_) {
    row.along = alongStep(row);
    most = std::max(most, std::abs(row.along));
  }
  return most;
}

// How much of the step goes to the function's least along it. The derivative rises in a straight
// line from kink to kink, where rows come to a limit or leave it.
double NewtonRows::lengthOfStep() {
  double value = 0, slope = 0;
  for (std::size_t i = 0; i + kSize < step_.size(); ++i) {
    value += gradient_[i] * step_[i];
    slope += step_[i] * step_[i];
  }
  kinks_.clear();
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    Row& row = rows_[r];
    row.slope *= kFade;
    if (row.slope * row.inverse < kNoSlope) row.slope = 0;
    if (row.along == 0 || !(row.low < row.high)) continue;
    const double rise = row.along * row.along / row.soft;
    if (row.isWithin)
      slope += rise;
    else
      row.slope = std::max(row.slope, (impulses_[r] - std::clamp((row.apart - row.along) / row.soft,
                                                                 row.low, row.high)) /
                                          row.along);
    const double low = (row.apart - row.soft * row.low) / row.along,
                 high = (row.apart - row.soft * row.high) / row.along;
    const double first = std::min(low, high), last = std::max(low, high);
    const bool comes = !row.isWithin && first > 0 && first < kLongest;
    if (comes) kinks_.push_back({first, rise});
    if ((row.isWithin || comes) && last > 0 && last < kLongest) kinks_.push_back({last, -rise});
  }
  std::sort(kinks_.begin(), kinks_.end());
  double at = 0;
  for (const Kink& kink : kinks_) {
    const double next = value + slope * (kink.at - at);
    if (next >= 0) break;
    value = next;
    at = kink.at;
    slope += kink.slope;
  }
  return slope > 0 ? std::min(at - value / slope, kLongest) : 1;
}

void NewtonRows::move(double length) {
  for (std::size_t i = 0; i < u_.size(); ++i) u_[i] += length * step_[i];
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    Row& row = rows_[r];
    row.apart -= length * row.along;
    impulses_[r] = std::clamp(row.apart / row.soft, row.low, row.high);
  }
}

// How much the normal impulses change friction's limits after these changes of them, as the matrix
// has it: rows at their limits push by their changes, those within theirs answer.
void NewtonRows::answer(const std::vector<double>& changes, std::vector<double>& answers) {
  std::fill(step_.begin(), step_.end(), 0.0);
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const Row& row = rows_[firstFriction_ + i];
    const double push = row.side * changes[i] * row.unit;
    for (int side = 0; push != 0 && side < 2; ++side) {
      double* const at = &step_[static_cast<std::size_t>(kSize * row.body[side])];
      for (int k = 0; k < kSize; ++k) at[k] += push * row.of[side][k];
    }
  }
  std::fill(step_.end() - kSize, step_.end(), 0.0);
  matrix_.solve(step_.data());
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const Row &row = rows_[firstFriction_ + i],
              &normal = rows_[static_cast<std::size_t>(row.normal)];
    const double apart = row.friction > 0 && normal.isWithin ? alongStep(normal) : 0;
    answers[i] = -row.friction * apart / (normal.soft * row.unit);
  }
}

// The changes d of friction's limits of which d - answer(d) is what they want, by generalized
// conjugate residuals (Eisenstat, Elman, Schultz, SIAM J. Numer. Anal. 20, 1983). They leave a
// part; the next step's limits want that.
void NewtonRows::foresee() {
  const std::size_t count = rows_.size() - firstFriction_;
  const auto dot = [&](const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += a[i] * b[i];
    return sum;
  };
  const auto add = [&](double part, const std::vector<double>& from, std::vector<double>& to) {
    for (std::size_t i = 0; i < count; ++i) to[i] += part * from[i];
  };
  std::vector<double>& left = wants_;
  foreseen_.assign(count, 0);
  const double enough = kLeft * kLeft * dot(left, left);
  for (int n = 0; n < kAnswers && dot(left, left) > enough; ++n) {
    Answered& own = answered_[n];
    own.change = left;
    own.wants.resize(count);
    answer(own.change, own.wants);
    for (std::size_t i = 0; i < count; ++i) own.wants[i] = own.change[i] - own.wants[i];
    for (const Answered* other = answered_; other != &own; ++other) {
      const double part = -dot(own.wants, other->wants) / other->square;
      add(part, other->wants, own.wants);
      add(part, other->change, own.change);
    }
    own.square = dot(own.wants, own.wants);
    if (!(own.square > 0)) break;
    const double part = dot(left, own.wants) / own.square;
    add(part, own.change, foreseen_);
    add(-part, own.wants, left);
  }
  std::swap(wants_, foreseen_);
}

// Sets friction's limits by the normal impulses; with `foresees` by those that they lead to.
// Returns by how much a row's speed was off [m/s].
double NewtonRows::followNormals(double few, bool foresees) {
  double off = 0;
  shrinks_ = shrinks_ || slow_ >= kFollowings;
  wants_.clear();
  for (std::size_t r = firstFriction_; r < rows_.size(); ++r) {
    Row& row = rows_[r];
    const double normal = impulses_[static_cast<std::size_t>(row.normal)];
    const double most = shrinks_ ? row.high : row.most;
    const double high = std::min(most, row.friction * std::max(0.0, normal));
    wants_.push_back((high - row.high) / row.unit);
    const bool slides = std::abs(impulses_[r]) >= std::min(high, row.high);
    row.side = slides ? (impulses_[r] < 0 ? -1 : 1) : 0;
    if (slides) off = std::max(off, std::abs(high - row.high) * row.inverse);
  }
  slow_ = off < kNearer * nearest_ ? 0 : slow_ + 1;
  if (slow_ == 0) nearest_ = off;
  if (foresees && !shrinks_ && off > few) foresee();
  for (std::size_t r = firstFriction_; r < rows_.size(); ++r) {
    Row& row = rows_[r];
    row.high = std::clamp(row.high + row.unit * wants_[r - firstFriction_], 0.0, row.most);
    row.low = -row.high;
  }
  return off;
}

const std::vector<double>& NewtonRows::solve(const Pools& pools,
                                             const btAlignedObjectArray<btSolverBody>& bodies,
                                             double speed) {
  number(bodies);
  read(pools, bodies);
  findPairs();
  begin();
  bool isFactored = false;
  double off = 0;  // that friction's limits were, the last time
  nearest_ = std::numeric_limits<double>::infinity();
  slow_ = 0;
  shrinks_ = false;
  agree_ = false;
  for (int step = 0; step < kMostSteps; ++step) {
    ++steps_;
    const bool first = step == 0;
    const int changed = classify(first);
    if (changed > 0 || !isFactored) isFactored = matrix_.factor();
    if (!isFactored) break;
    const double most = measureStep(), length = first ? 1 : lengthOfStep();
    move(length);
    if (most > speed && length < kWhole) continue;
    off = followNormals(agreesSoon(off, speed), length >= kWhole && off > 0);
    agree_ = off <= speed && most <= speed;
    if (agree_) break;
  }
  agree_ = agree_ && !shrinks_;
  return impulses_;
}

}  // namespace cloudcontact
