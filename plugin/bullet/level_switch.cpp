// Finer until the contact's own error is within the tolerance; then the jump in depth.
#include "bullet/level_switch.h"

#include <cloudcontact/bullet/cloud_contact_settings.h>
#include <cloudcontact/contact/depth_error.h>

#include <algorithm>

namespace cloudcontact {

namespace {

constexpr double kFade = 0.2;     // [s] in which a jump in depth fades away
constexpr int kMostRepeats = 20;  // both bodies' levels, and a tight fit

}  // namespace

LevelSwitch::Deepest LevelSwitch::deepestOf(const PairQuery& query, const ContactResult& found) {
  Deepest deepest;
  for (const ContactPoint& point : found.points)
    if (point.depth > deepest.depth)
      deepest = {point.depth, query.a.pose.toLocal(point.position),
                 query.b.pose.toLocal(point.position), point.normal};
  return deepest;
}

// What the last step's contact has become, moved with the bodies to first order.
double LevelSwitch::movedDepth(const PairQuery& query) const {
  if (!(last_.depth > 0)) return 0;
  const Vec3 way = query.a.pose.toWorld(last_.inA) - query.b.pose.toWorld(last_.inB);
  return std::max(0.0, last_.depth + last_.normal.dot(way));
}

void LevelSwitch::jump(double by, double most, double step) {
  left_ -= step;
  if (left_ <= 0) offset_ = left_ = 0;
  if (by == 0) return;
  const double now = offset_ * left_ / kFade + by;
  offset_ = std::clamp(now, -most, most);
  left_ = kFade;
}

void LevelSwitch::settle(const Pair& pair, PairQuery& query, double step, ContactResult& found) {
  refined_ = 0;
  const CloudShape* const clouds[2] = {cloudOf(pair.a), cloudOf(pair.b)};
  PairLevels& levels = pair.reader.levels();
  const PairLevels kept = levels;
  error_ = depthError(query.a, query.b, found);
  for (int k = 0; k < kMostRepeats && levels.refines(query.levels, clouds, error_, found); ++k) {
    const LevelChoice last = query.levels;
    pair.reader.chooseLevels(pair.settings, pair.a, pair.b, query);
    if (query.levels == last) continue;
    pair.finder.search(query.a, query.b, query.settings, found);
    ++refined_;
    error_ = depthError(query.a, query.b, found);
  }
  if (!(step > 0)) {
    levels = kept;
    return;
  }
  const double now = std::max(0.0, depthOf(found));
  jump(levels.differs(query.levels) ? movedDepth(query) - now : 0, query.levels.tolerance, step);
  last_ = deepestOf(query, found);
  levels.learn(query.levels, error_, found);
}

void LevelSwitch::fade(ContactResult& found) const {
  if (!fades()) return;
  const double more = offset_ * left_ / kFade;
  for (ContactPoint& point : found.points) point.depth += more;
  for (Patch& patch : found.patches) patch.depth += more;
}

}  // namespace cloudcontact
