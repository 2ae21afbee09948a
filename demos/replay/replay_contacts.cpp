// Compares each manifold with its stored patch of the last frame.
#include "replay/replay_contacts.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cloudcontact::program {
namespace {

// Invisible changes, relative to a force or depth and to the largest so far: half a pixel on an
// arrow of 100 px.
constexpr float kOfItself = 0.005f, kOfTheMost = 1e-4f;

}  // namespace

// A new patch, turned so that a fixed body is its first.
struct ReplayContacts::Seen {
  int a, b;
  double sign;  // -1 if turned
  std::span<const ContactNow> points;

  Eigen::Vector3f forceOf(const ContactNow& c) const { return (sign * c.force).cast<float>(); }
  ReplayPatch disc() const;
};

// A disc of radius R has the second moment R^2 / 2 about its center in its plane.
ReplayPatch ReplayContacts::Seen::disc() const {
  double weight = 0, moment = 0, deepest = points.front().depth;
  Vec3 center = Vec3::Zero(), normal = Vec3::Zero();
  for (const ContactNow& c : points) {
    const double w = c.force.norm() + 1e-12;
    weight += w;
    center += w * c.position;
    normal += w * c.normal;
    deepest = std::max(deepest, c.depth);
  }
  center /= weight;
  for (const ContactNow& c : points)
    moment += (c.force.norm() + 1e-12) * (c.position - center).squaredNorm();
  return {a,
          b,
          0,
          static_cast<std::uint32_t>(points.size()),
          center.cast<float>(),
          (sign * normal.normalized()).cast<float>(),
          static_cast<float>(std::sqrt(2 * moment / weight)),
          static_cast<float>(deepest)};
}

// Compares the k-th manifold with the k-th of the last frame: Bullet keeps their order unless one
// ends.
void ReplayContacts::add(const ContactsNow& now, const std::vector<bool>& isFixed) {
  const std::size_t before = shownEnd_.size() < 2 ? 0 : shownEnd_[shownEnd_.size() - 2];
  const std::size_t end = shown_.size();
  for (std::size_t k = 0; k < now.patches.size(); ++k) {
    const PatchNow& patch = now.patches[k];
    Seen seen{patch.a, patch.b, 1, now.of(patch)};
    if (isFixed[static_cast<std::size_t>(patch.b)]) std::swap(seen.a, seen.b), seen.sign = -1;
    const bool known = before + k < end && looksTheSame(patches_[shown_[before + k]], seen);
    if (!known) store(seen);
    shown_.push_back(known ? shown_[before + k] : static_cast<std::uint32_t>(patches_.size() - 1));
  }
  shownEnd_.push_back(shown_.size());
}

bool ReplayContacts::looksTheSame(const ReplayPatch& stored, const Seen& patch) const {
  if (stored.a != patch.a || stored.b != patch.b || stored.points != patch.points.size())
    return false;
  const ReplayPoint* p = points_.data() + stored.first;
  for (const ContactNow& c : patch.points) {
    const float force = kOfItself * p->force.norm() + kOfTheMost * mostForce_;
    const float depth = kOfItself * std::abs(p->depth) + kOfTheMost * mostDepth_;
    const bool same = (c.position.cast<float>() - p->position).squaredNorm() <= still_ * still_ &&
                      (patch.forceOf(c) - p->force).squaredNorm() <= force * force &&
                      std::abs(std::max(float(c.depth), 0.f) - std::max(p->depth, 0.f)) <= depth;
    if (!same) return false;
    ++p;
  }
  return true;
}

void ReplayContacts::store(const Seen& patch) {
  patches_.push_back(patch.disc());
  patches_.back().first = static_cast<std::uint32_t>(points_.size());
  for (const ContactNow& c : patch.points) {
    points_.push_back({c.position.cast<float>(), patch.forceOf(c), float(c.depth)});
    mostForce_ = std::max(mostForce_, points_.back().force.norm());
    mostDepth_ = std::max(mostDepth_, points_.back().depth);
  }
}

std::span<const std::uint32_t> ReplayContacts::shownAt(std::size_t frame) const {
  const std::size_t first = frame == 0 ? 0 : shownEnd_[frame - 1];
  return {shown_.data() + first, shownEnd_[frame] - first};
}

void ReplayContacts::thin() {
  ReplayContacts half(still_);
  half.mostForce_ = mostForce_, half.mostDepth_ = mostDepth_;
  std::vector<std::uint32_t> moved(patches_.size(), UINT32_MAX);
  for (std::size_t frame = 0; frame < frames(); frame += 2) {
    for (const std::uint32_t patch : shownAt(frame)) {
      if (moved[patch] == UINT32_MAX) {
        moved[patch] = static_cast<std::uint32_t>(half.patches_.size());
        const auto points = of(patches_[patch]);
        half.patches_.push_back(patches_[patch]);
        half.patches_.back().first = static_cast<std::uint32_t>(half.points_.size());
        half.points_.insert(half.points_.end(), points.begin(), points.end());
      }
      half.shown_.push_back(moved[patch]);
    }
    half.shownEnd_.push_back(half.shown_.size());
  }
  *this = std::move(half);
}

}  // namespace cloudcontact::program
