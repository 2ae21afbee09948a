// Packs the texts, figures, contacts and voxels of a page (page_record.h).
#include "replay/page_record.h"

#include <map>

#include "replay/body_colors.h"
#include "replay/page_contacts.h"
#include "replay/voxel_shell.h"

namespace cloudcontact::program {
namespace {

Json figuresJson(const ReplayTake& take, PackedArrays& arrays) {
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
  explicit Shells(PackedArrays& arrays) : arrays_(arrays) {}

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

  PackedArrays& arrays_;
  Json out_ = Json::array();
  std::vector<VoxelShell> shells_;
  std::map<const SurfaceField*, std::size_t> known_;
};

// Pairs of a time [s] and a mass [kg], null where nothing is left.
Json massesJson(const std::vector<MassKey>& masses) {
  Json out = Json::array();
  for (const MassKey& key : masses) out.push_back({key.time, key.mass ? Json(*key.mass) : Json()});
  return out;
}

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
                      {"masses", massesJson(body.masses)},
                      {"color", colors[i].name},
                      {"cuttable", body.isCuttable},
                      {"pullable", body.isPullable},
                      {"clouds", clouds}});
  }
  return bodies;
}

}  // namespace

std::string pageRecord(const Replay& replay) {
  PackedArrays arrays;
  Json json = {{"live", replay.isLive}, {"title", replay.title}, {"story", replay.story},
               {"watch", replay.watch}, {"setup", replay.setup}, {"seconds", float(replay.seconds)},
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
                             {"contacts", contactsJson(take.contacts, arrays)}});
  json["shells"] = shells.json();
  return arrays.packed(json);
}

}  // namespace cloudcontact::program
