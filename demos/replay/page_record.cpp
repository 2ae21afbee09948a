// Rounds numbers to visible differences before packing: a contact at rest then has the same bytes
// in every frame, which compress to almost nothing.
#include "replay/page_record.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "io/json.h"
#include "replay/body_colors.h"
#include "replay/voxel_shell.h"

namespace cloudcontact::program {
namespace {

class Arrays {
 public:
  template <class Number>
  Json add(const std::vector<Number>& numbers, const char* type) {
    bytes_.resize((bytes_.size() + 7) / 8 * 8);
    const std::size_t at = bytes_.size(), size = numbers.size() * sizeof(Number);
    bytes_.resize(at + size);
    if (size > 0) std::memcpy(bytes_.data() + at, numbers.data(), size);
    return {{"at", at}, {"length", numbers.size()}, {"type", type}};
  }
  Json add(const std::vector<std::uint8_t>& v) { return add(v, "u8"); }
  Json add(const std::vector<std::int8_t>& v) { return add(v, "i8"); }
  Json add(const std::vector<std::uint16_t>& v) { return add(v, "u16"); }
  Json add(const std::vector<std::int16_t>& v) { return add(v, "i16"); }
  Json add(const std::vector<std::uint32_t>& v) { return add(v, "u32"); }
  Json add(const std::vector<float>& v) { return add(v, "f32"); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

// An inline std::lround, whose calls take a third of the time.
int rounded(float value) {
  return static_cast<int>(value < 0 ? value - 0.5f : value + 0.5f);
}

// Rounds positions in a box, directions and sizes to small integers.
struct Rounding {
  Eigen::AlignedBox3f box;
  float size = 0, mostForce = 0, mostDepth = 0;

  explicit Rounding(const ReplayTake& take) {
    for (const ReplayPoint& p : take.contacts.points()) {
      box.extend(p.position);
      mostForce = std::max(mostForce, p.force.norm());
      mostDepth = std::max(mostDepth, std::abs(p.depth));
    }
    for (const ReplayPatch& p : take.contacts.patches()) box.extend(p.position);
    if (box.isEmpty()) box.extend(Eigen::Vector3f(0, 0, 0));
    size = std::max(1e-9f, box.diagonal().norm());
  }
  std::uint16_t place(float value, int axis) const {
    return whole((value - box.min()[axis]) / size, kPlaces);
  }
  std::uint16_t length(float value) const { return whole(value / size, kPlaces); }
  std::uint16_t force(float value) const {
    return whole(mostForce > 0 ? std::sqrt(value / mostForce) : 0, kSteps);
  }
  std::int16_t depth(float value) const {
    return static_cast<std::int16_t>(rounded(mostDepth > 0 ? kSteps * value / mostDepth : 0));
  }
  static std::int8_t direction(float value) {
    return static_cast<std::int8_t>(rounded(127 * std::clamp(value, -1.f, 1.f)));
  }

 private:
  // Finer steps cost bytes, because bodies almost at rest would change in every frame.
  static constexpr float kPlaces = 8191, kSteps = 1023;
  static std::uint16_t whole(float share, float steps) {
    return static_cast<std::uint16_t>(rounded(steps * std::clamp(share, 0.f, 1.f)));
  }
};

void addPlace(std::vector<std::uint16_t>& out, const Rounding& rounding, const Eigen::Vector3f& p) {
  for (int axis = 0; axis < 3; ++axis) out.push_back(rounding.place(p[axis], axis));
}

void addDirection(std::vector<std::int8_t>& out, const Eigen::Vector3f& v) {
  const float length = v.norm();
  for (int axis = 0; axis < 3; ++axis)
    out.push_back(length > 0 ? Rounding::direction(v[axis] / length) : std::int8_t{0});
}

Json contactsJson(const ReplayTake& take, Arrays& arrays) {
  const Rounding rounding(take);
  std::vector<std::uint32_t> firstShown = {0}, firstPoint;
  std::vector<std::uint16_t> patchPlace, pointPlace, radius, force;
  std::vector<std::int8_t> normal, direction;
  std::vector<std::int16_t> patchDepth, pointDepth;
  std::vector<std::uint16_t> count;
  for (const ReplayPatch& p : take.contacts.patches()) {
    firstPoint.push_back(p.first);
    count.push_back(static_cast<std::uint16_t>(p.points));
    addPlace(patchPlace, rounding, p.position);
    addDirection(normal, p.normal);
    radius.push_back(rounding.length(p.radius));
    patchDepth.push_back(rounding.depth(p.depth));
  }
  for (const ReplayPoint& p : take.contacts.points()) {
    addPlace(pointPlace, rounding, p.position);
    addDirection(direction, p.force);
    force.push_back(rounding.force(p.force.norm()));
    pointDepth.push_back(rounding.depth(p.depth));
  }
  for (std::size_t frame = 0; frame < take.contacts.frames(); ++frame)
    firstShown.push_back(firstShown.back() +
                         static_cast<std::uint32_t>(take.contacts.shownAt(frame).size()));
  return {{"low", asJson(Vec3(rounding.box.min().cast<double>()))},
          {"size", rounding.size},
          {"mostForce", rounding.mostForce},
          {"mostDepth", rounding.mostDepth},
          {"firstShown", arrays.add(firstShown)},
          {"shown", arrays.add(take.contacts.shown())},
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

Json figuresJson(const ReplayTake& take, Arrays& arrays) {
  std::vector<float> time, kinetic, potential, spring, deepest, narrowPhase;
  for (const ReplayFrame& f : take.frames) {
    time.push_back(float(f.time));
    kinetic.push_back(float(f.kinetic));
    potential.push_back(float(f.potential));
    spring.push_back(float(f.spring));
    deepest.push_back(float(f.deepest));
    narrowPhase.push_back(float(f.narrowPhase));
  }
  return {{"time", arrays.add(time)},           {"kinetic", arrays.add(kinetic)},
          {"potential", arrays.add(potential)}, {"spring", arrays.add(spring)},
          {"deepest", arrays.add(deepest)},     {"narrowPhase", arrays.add(narrowPhase)}};
}

// Voxel shells, shared by bodies.
class Shells {
 public:
  explicit Shells(Arrays& arrays) : arrays_(arrays) {}

  Json placed(const DrawnCloud& cloud) {
    const auto [known, isNew] = known_.try_emplace(cloud.field.get(), 0);
    if (isNew) known->second = numberOf(voxelShell(cloud.field->cloud()));
    const auto& q = cloud.pose.orientation;
    return {{"shell", known->second},
            {"position", asJson(cloud.pose.position)},
            {"orientation", {q.x(), q.y(), q.z(), q.w()}}};
  }
  const Json& json() const { return out_; }

 private:
  // Stores equal clouds of several worlds once.
  std::size_t numberOf(const VoxelShell& s) {
    std::size_t which = 0;
    while (which < shells_.size() && !(shells_[which] == s)) ++which;
    if (which < shells_.size()) return which;
    shells_.push_back(s);
    out_.push_back({{"edge", s.edge},
                    {"origin", asJson(s.origin)},
                    {"x", arrays_.add(s.x)},
                    {"y", arrays_.add(s.y)},
                    {"z", arrays_.add(s.z)},
                    {"coverage", arrays_.add(s.coverage)},
                    {"open", arrays_.add(s.open)}});
    return which;
  }

  Arrays& arrays_;
  Json out_ = Json::array();
  std::vector<VoxelShell> shells_;
  std::map<const SurfaceField*, std::size_t> known_;
};

Json bodiesJson(const ReplayTake& take, Shells& shells) {
  Json bodies = Json::array();
  const std::vector<BodyColor> colors = bodyColors(take.bodies);
  for (std::size_t i = 0; i < take.bodies.size(); ++i) {
    const ReplayBody& body = take.bodies[i];
    Json clouds = Json::array();
    for (const DrawnCloud& cloud : body.drawn.clouds) clouds.push_back(shells.placed(cloud));
    bodies.push_back({{"name", body.name},
                      {"fixed", body.isStatic},
                      {"plane", body.drawn.isPlane()},
                      {"mass", body.mass},
                      {"color", colors[i].name},
                      {"clouds", clouds}});
  }
  return bodies;
}

}  // namespace

std::string pageRecord(const Replay& replay) {
  Arrays arrays;
  Json json = {{"title", replay.title},
               {"story", replay.story},
               {"watch", replay.watch},
               {"setup", replay.setup},
               {"seconds", float(replay.seconds)},
               {"voxel", replay.voxel}};
  json["checks"] = Json::array();
  for (const ReplayCheck& c : replay.checks)
    json["checks"].push_back({{"expected", c.expected}, {"found", c.found}, {"holds", c.holds}});
  json["facts"] = Json::array();
  for (const auto& [name, figure] : replay.facts) json["facts"].push_back({name, figure});
  Shells shells(arrays);
  json["takes"] = Json::array();
  for (const ReplayTake& take : replay.takes)
    json["takes"].push_back({{"label", take.label},
                             {"offset", asJson(take.offset)},
                             {"low", asJson(Vec3(take.extent.min()))},
                             {"high", asJson(Vec3(take.extent.max()))},
                             {"startLow", asJson(Vec3(take.start.min()))},
                             {"startHigh", asJson(Vec3(take.start.max()))},
                             {"bodies", bodiesJson(take, shells)},
                             {"figures", figuresJson(take, arrays)},
                             {"contacts", contactsJson(take, arrays)}});
  json["shells"] = shells.json();
  std::string text = jsonText(json, -1);
  while ((8 + text.size()) % 8 != 0) text += ' ';
  const auto length = static_cast<std::uint32_t>(text.size());
  std::string bytes = "RPLY";
  for (int k = 0; k < 4; ++k) bytes += static_cast<char>(length >> 8 * k & 255);
  return bytes + text + arrays.bytes();
}

}  // namespace cloudcontact::program
