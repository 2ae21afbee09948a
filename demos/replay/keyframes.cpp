// Douglas and Peucker's thinning (1973, "Algorithms for the reduction of the number of points
// required to represent a digitized line"), on poses instead of points: the key between two kept
// ones that strays most from their interpolation is kept too, where it strays too far, and the
// two halves are looked at in turn. It needs all poses at hand, so it runs on a few hundred at a
// time: memory stays bounded, a step costs a microsecond a body, and a body at rest has a key
// every kBlock steps.
#include "keyframes.h"

#include <algorithm>
#include <utility>

namespace cloudcontact::program {
namespace {

constexpr std::size_t kBlock = 256;  // poses that wait to be thinned

}  // namespace

Pose between(const PoseKey& from, const PoseKey& to, double time) {
  const double span = to.time - from.time;
  const double share = span > 0 ? (time - from.time) / span : 0;
  return {from.pose.orientation.slerp(share, to.pose.orientation),
          from.pose.position + share * (to.pose.position - from.pose.position)};
}

void Keyframes::add(double time, const Pose& pose) {
  PoseKey key{time, pose};
  // A rotation has two quaternions; the nearer one keeps a viewer from turning the long way.
  if (!waiting_.empty() && waiting_.back().pose.orientation.dot(pose.orientation) < 0)
    key.pose.orientation.coeffs() = -key.pose.orientation.coeffs();
  waiting_.push_back(key);
  if (keys_.empty()) keys_.push_back(key);
  if (waiting_.size() >= kBlock) thin();
}

void Keyframes::finish() {
  if (waiting_.size() > 1) thin();
  waiting_.clear();
  // A body that never moved needs one key.
  if (keys_.size() == 2 && strays(keys_[1], keys_[0], keys_[0]) == 0) keys_.pop_back();
}

double Keyframes::strays(const PoseKey& seen, const PoseKey& from, const PoseKey& to) const {
  const Pose shown = between(from, to, seen.time);
  // |q - p| is 2 sin(angle / 4), so twice it is a chord's 2 sin(angle / 2) or a little more.
  const auto &p = shown.orientation.coeffs(), &q = seen.pose.orientation.coeffs();
  const double turned = 2 * std::min((p - q).norm(), (p + q).norm());
  return (shown.position - seen.pose.position).norm() + turned * reach_;
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
    for (std::size_t i = first + 1; i < last; ++i) {
      const double far = strays(waiting_[i], waiting_[first], waiting_[last]);
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
