// The algorithm of Douglas and Peucker (1973, "Algorithms for the reduction of the number of points
// required to represent a digitized line") on poses instead of points: the pose that deviates most
// from the interpolation between two keys becomes a key if it deviates too far, and both halves are
// processed in turn. It runs on blocks of a few hundred poses, which bounds the memory.
#include "replay/keyframes.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cloudcontact::program {
namespace {

constexpr std::size_t kBlock = 256;  // poses in a block

// Below this angle between two quaternions lerp replaces slerp: the error is a^2 / 8 = 1e-9, and a
// body at rest needs no sines.
constexpr double kStraight = 1e-4;

// The interpolation between two keys, with the terms that all instants share.
class Way {
 public:
  Way(const PoseKey& from, const PoseKey& to) : from_(from), to_(to) {
    const double cosine = from.pose.orientation.dot(to.pose.orientation);
    sign_ = cosine < 0 ? -1 : 1;
    angle_ = std::acos(std::min(1.0, std::abs(cosine)));
    inverseSine_ = angle_ > kStraight ? 1 / std::sin(angle_) : 0;
  }
  Pose at(double time) const {
    const double span = to_.time - from_.time;
    const double share = span > 0 ? (time - from_.time) / span : 0;
    double before = 1 - share, after = share;
    if (inverseSine_ > 0) {
      before = std::sin(before * angle_) * inverseSine_;
      after = std::sin(after * angle_) * inverseSine_;
    }
    Pose pose;
    pose.orientation.coeffs() =
        before * from_.pose.orientation.coeffs() + sign_ * after * to_.pose.orientation.coeffs();
    pose.position = from_.pose.position + share * (to_.pose.position - from_.pose.position);
    return pose;
  }

 private:
  const PoseKey &from_, &to_;
  double sign_, angle_, inverseSine_;
};

bool same(const Pose& a, const Pose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
}

// Upper bound for the distance between a point within `reach` at pose `seen` and at pose `shown`.
double strays(const Pose& seen, const Pose& shown, double reach) {
  // |q - p| is 2 sin(angle / 4); twice that bounds the chord 2 sin(angle / 2).
  const auto &p = shown.orientation.coeffs(), &q = seen.orientation.coeffs();
  const double turned = 2 * std::sqrt(std::min((p - q).squaredNorm(), (p + q).squaredNorm()));
  return (shown.position - seen.position).norm() + turned * reach;
}

}  // namespace

Pose between(const PoseKey& from, const PoseKey& to, double time) {
  return Way(from, to).at(time);
}

void Keyframes::add(double time, const Pose& pose) {
  PoseKey key{time, pose};
  // Of the two quaternions of a rotation take the nearer one, so that a viewer turns the short way.
  if (!waiting_.empty() && waiting_.back().pose.orientation.dot(pose.orientation) < 0)
    key.pose.orientation.coeffs() = -key.pose.orientation.coeffs();
  // Poses that equal the last one to the bit cost no memory.
  const std::size_t n = waiting_.size();
  if (n >= 2 && same(waiting_[n - 1].pose, key.pose) && same(waiting_[n - 2].pose, key.pose)) {
    waiting_.back().time = time;
    return;
  }
  waiting_.push_back(key);
  if (keys_.empty()) keys_.push_back(key);
  if (waiting_.size() >= kBlock) thin();
}

void Keyframes::finish() {
  if (waiting_.size() > 1) thin();
  waiting_.clear();
  // One key is enough for a body that never moves.
  const auto moved = [this](const PoseKey& k) {
    return strays(k.pose, keys_.front().pose, reach_) > 0;
  };
  if (!keys_.empty() && std::none_of(keys_.begin(), keys_.end(), moved)) keys_.resize(1);
}

void Keyframes::thin() {
  std::vector<bool> kept(waiting_.size(), false);
  kept.back() = true;
  std::vector<std::pair<std::size_t, std::size_t>> spans = {{0, waiting_.size() - 1}};
  while (!spans.empty()) {
    const auto [first, last] = spans.back();
    spans.pop_back();
    std::size_t worst = first;
    double most = tolerance_;
    const Way way(waiting_[first], waiting_[last]);
    for (std::size_t i = first + 1; i < last; ++i) {
      const double far = strays(waiting_[i].pose, way.at(waiting_[i].time), reach_);
      if (far > most) most = far, worst = i;
    }
    if (worst == first) continue;
    kept[worst] = true;
    spans.emplace_back(first, worst);
    spans.emplace_back(worst, last);
  }
  for (std::size_t i = 1; i < waiting_.size(); ++i)
    if (kept[i]) keys_.push_back(waiting_[i]);
  waiting_ = {waiting_.back()};
}

}  // namespace cloudcontact::program
