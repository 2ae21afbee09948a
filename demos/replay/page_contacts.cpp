// Rounds numbers to visible differences before packing: a contact at rest then has the same bytes
// in every frame, which compress to almost nothing.
#include "replay/page_contacts.h"

#include <algorithm>
#include <cmath>

namespace cloudcontact::program {
namespace {

// An inline std::lround, whose calls take a third of the time.
int rounded(float value) {
  return static_cast<int>(value < 0 ? value - 0.5f : value + 0.5f);
}

// Rounds positions, directions and sizes to small integers. The grid of positions is the scene's,
// and gaps do not count for the scale of depths: a body that flies off takes no digits from the
// contacts of the others.
struct Rounding {
  float grid = 0, mostForce = 0, mostDepth = 0;

  explicit Rounding(const ReplayContacts& contacts) : grid(gridOf(contacts)) {
    for (const ReplayPoint& p : contacts.points()) {
      mostForce = std::max(mostForce, p.force.norm());
      mostDepth = std::max(mostDepth, p.depth);
    }
  }
  std::int32_t place(float value) const {
    constexpr double kMost = 2e9;  // farther contacts are drawn nearer
    return static_cast<std::int32_t>(std::lround(std::clamp(double(value / grid), -kMost, kMost)));
  }
  std::uint16_t length(float value) const { return whole(value / grid / 65535, 65535); }
  std::uint16_t force(float value) const {
    return whole(mostForce > 0 ? std::sqrt(value / mostForce) : 0, kSteps);
  }
  std::int16_t depth(float value) const {
    // Of gaps the page reads the sign alone.
    const float share = mostDepth > 0 ? std::max(value / mostDepth, -1.f) : value < 0 ? -1.f : 0.f;
    return static_cast<std::int16_t>(rounded(kSteps * share));
  }
  static std::int8_t direction(float value) {
    return static_cast<std::int8_t>(rounded(127 * std::clamp(value, -1.f, 1.f)));
  }

 private:
  // Finer steps cost bytes, because bodies almost at rest would change in every frame.
  static constexpr float kSteps = 1023;
  static float gridOf(const ReplayContacts& contacts) {
    constexpr float kStill = 4, kUnknown = 1e-6f;
    return contacts.still() > 0 ? kStill * contacts.still() : kUnknown;
  }
  static std::uint16_t whole(float share, float steps) {
    return static_cast<std::uint16_t>(rounded(steps * std::clamp(share, 0.f, 1.f)));
  }
};

void addPlace(std::vector<std::int32_t>& out, const Rounding& rounding, const Eigen::Vector3f& p) {
  for (int axis = 0; axis < 3; ++axis) out.push_back(rounding.place(p[axis]));
}

void addDirection(std::vector<std::int8_t>& out, const Eigen::Vector3f& v) {
  const float length = v.norm();
  for (int axis = 0; axis < 3; ++axis)
    out.push_back(length > 0 ? Rounding::direction(v[axis] / length) : std::int8_t{0});
}

}  // namespace

Json contactsJson(const ReplayContacts& contacts, PackedArrays& arrays) {
  const Rounding rounding(contacts);
  std::vector<std::uint32_t> firstShown = {0}, firstPoint;
  std::vector<std::int32_t> patchPlace, pointPlace;
  std::vector<std::uint16_t> radius, force;
  std::vector<std::int8_t> normal, direction;
  std::vector<std::int16_t> patchDepth, pointDepth;
  std::vector<std::uint16_t> count;
  for (const ReplayPatch& p : contacts.patches()) {
    firstPoint.push_back(p.first);
    count.push_back(static_cast<std::uint16_t>(p.points));
    addPlace(patchPlace, rounding, p.position);
    addDirection(normal, p.normal);
    radius.push_back(rounding.length(p.radius));
    patchDepth.push_back(rounding.depth(p.depth));
  }
  for (const ReplayPoint& p : contacts.points()) {
    addPlace(pointPlace, rounding, p.position);
    addDirection(direction, p.force);
    force.push_back(rounding.force(p.force.norm()));
    pointDepth.push_back(rounding.depth(p.depth));
  }
  for (std::size_t frame = 0; frame < contacts.frames(); ++frame)
    firstShown.push_back(firstShown.back() +
                         static_cast<std::uint32_t>(contacts.shownAt(frame).size()));
  return {{"grid", rounding.grid},
          {"mostForce", rounding.mostForce},
          {"mostDepth", rounding.mostDepth},
          {"firstShown", arrays.add(firstShown)},
          {"shown", arrays.add(contacts.shown())},
          {"patchPoint", arrays.add(firstPoint)},
          {"patchCount", arrays.add(count)},
          {"patchPlace", arrays.add(patchPlace)},
          {"patchNormal", arrays.add(normal)},
          {"patchRadius", arrays.add(radius)},
          {"patchDepth", arrays.add(patchDepth)},
          {"pointPlace", arrays.add(pointPlace)},
          {"pointDirection", arrays.add(direction)},
          {"pointForce", arrays.add(force)},
          {"pointDepth", arrays.add(pointDepth)}};
}

}  // namespace cloudcontact::program
