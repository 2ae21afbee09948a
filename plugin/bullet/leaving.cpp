// Overlaps that motion does not explain.
#include "bullet/leaving.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace cloudcontact {

namespace {

constexpr double kDeep = 3;     // [voxels] from here on normals of the field are not sure
constexpr double kGone = 0.1;   // [voxels] the law goes on
constexpr double kAgree = 0.8;  // of the length of a sum of normals to that of all: one way out
// [1/s] Share of an overlap that leaves. Bullet's own bodies leave by a fifth a step; at 60 Hz this
// is the same.
constexpr double kRate = 12;
constexpr double kLess = 0.98, kStillFor = 0.25;  // of the least depth; [s] without that
constexpr double kFaster = 1.02;  // than the last speed: something else moves the bodies

double deepestOf(const ContactResult& contact) {
  double depth = -std::numeric_limits<double>::infinity();
  for (const ContactPoint& point : contact.points) depth = std::max(depth, point.depth);
  return depth;
}

constexpr std::uint32_t kFirstId = 0x7ffffff0;  // no patch has such points

// The points as one, in the middle; its depth is the deepest one's. Empty if they push against each
// other.
std::optional<ContactPoint> asOne(const ContactResult& contact) {
  ContactPoint sum;
  sum.normal.setZero();
  double weight = 0;
  for (const ContactPoint& point : contact.points) {
    if (point.depth <= 0) continue;
    const double share = point.stiffness * point.depth;
    sum.normal += share * point.normal;
    sum.position += share * point.position;
    weight += share;
  }
  if (!(weight > 0) || sum.normal.norm() < kAgree * weight) return std::nullopt;
  sum.normal.normalize();
  sum.position /= weight;
  sum.depth = deepestOf(contact);
  return sum;
}

// The speed at which the pair's spring would push it out from this depth [m/s].
double springSpeed(const PairQuery& query, const ContactResult& found, double depth) {
  const PairLaw& law = query.law;
  if (law.remembering || std::holds_alternative<Rigid>(law.shared) || !(query.mass > 0)) return 0;
  double force = 0;
  if (law.automatic) force = law.automatic->force(depth);
  for (const ContactPoint& point : found.points)
    if (!law.automatic) force += point.stiffness * std::max(0.0, point.depth);
  return std::sqrt(force * depth / query.mass);
}

}  // namespace

bool Leaving::begins(const PairQuery& query, const ContactResult& found, double most, double step) {
  if (!(query.mass > 0) || most == std::numeric_limits<double>::infinity()) return false;
  const double depth = deepestOf(found), before = std::max(0.0, last_);
  double explained = query.voxel + step * closingSpeed(query.a, query.b);
  if (last_ > kNone) explained += query.voxel + before;  // depths of a contact are not exact
  if (last_ > kNone && !found.points.empty() && !(depth > explained)) return false;
  const bool inside = out_.isInside(query.a, query.b);
  if (held_) held_ = inside || !found.points.empty();
  if (held_) return false;
  if (inside) return way_ = out_.find(query.a, query.b) && out_.length() > explained;
  return depth > explained && asOne(found) && springSpeed(query, found, depth) > most;
}

bool Leaving::goesOn(const PairQuery& query, const ContactResult& found) {
  const double depth = deepestOf(found), deep = kDeep * query.voxel;
  const auto one = asOne(found);
  const bool known = one && depth < deep;
  if (way_) way_ = out_.follow(query.a, query.b) && out_.length() > (known ? deep : query.voxel);
  if (!way_ && !known) way_ = out_.find(query.a, query.b) && out_.length() > query.voxel;
  if (way_) push_ = out_.push();
  if (way_) return true;
  if (one) push_ = *one;
  return one && depth > kGone * query.voxel;
}

void Leaving::setSpeed(const PairQuery& query, double most, double step) {
  const Vec3 meeting = query.a.motion.linear - query.b.motion.linear;
  const bool isOurs = -meeting.dot(push_.normal) <= kFaster * speed_;
  speed_ = std::min(most, push_.depth * (1 - std::exp(-kRate * step)) / step);
  brake_.reset();
  if (isOurs) brake_ = -speed_ * step;
}

ContactResult Leaving::contact() const {
  ContactResult contact;
  contact.points.assign(brake_ ? 2 : 1, push_);
  contact.points.front().id = kFirstId;
  if (brake_) {
    ContactPoint& brake = contact.points.back();
    brake.normal = -push_.normal;
    brake.depth = *brake_;
    brake.id = kFirstId + 1;
  }
  Patch patch;
  patch.position = push_.position;
  patch.normal = push_.normal;
  patch.depth = push_.depth;
  patch.points = static_cast<int>(contact.points.size());
  patch.doubt = Doubt::Deep;
  contact.patches.push_back(patch);
  return contact;
}

// Whether the overlap has become less lately.
bool Leaving::moves(double step) {
  still_ += step;
  if (push_.depth < kLess * least_) {
    least_ = push_.depth;
    still_ = 0;
  }
  return still_ <= kStillFor;
}

bool Leaving::update(const PairQuery& query, const ContactResult& found, double most, double step) {
  if (!on_) {
    way_ = false;
    on_ = begins(query, found, most, step);
    speed_ = most;
    least_ = std::numeric_limits<double>::infinity();
  }
  if (on_) on_ = goesOn(query, found);
  if (on_) held_ = !moves(step);
  if (held_) on_ = false;
  if (on_) setSpeed(query, most, step);
  touched(found);
  return on_;
}

void Leaving::touched(const ContactResult& found) {
  last_ = deepestOf(found);
}

void Leaving::reset() {
  on_ = held_ = false;
  last_ = kNone;
}

}  // namespace cloudcontact
