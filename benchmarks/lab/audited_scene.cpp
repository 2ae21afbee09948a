// Runs the scene and tells its energy audit (audited_scene.h).
#include "lab/audited_scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <sstream>

#include "io/errors.h"
#include "io/json.h"
#include "io/output_file.h"
#include "lab/energy_audit.h"
#include "lab/lab_results.h"
#include "scene/scene_clouds.h"
#include "scene/scene_file.h"
#include "scene/world.h"

namespace cloudcontact::program::lab {
namespace {

constexpr const char* kKinds[] = {"normal", "friction 1", "friction 2", "spring"};
constexpr double kMostSteps = 1e7;  // audit.json has a line a step

Json partsJson(const EnergyParts& p) {
  return {{"bodies", p.bodies},     {"springs", p.springs}, {"found", p.found},
          {"friction", p.friction}, {"normals", p.normals}, {"joints", p.joints},
          {"drivers", p.drivers},   {"solver", p.solver},   {"turning", p.turning},
          {"rest", p.rest}};
}

Json worstJson(const EnergyRow& row, const World& world) {
  if (!(row.energy > 0)) return nullptr;
  const auto name = [&](const btCollisionObject* object) {
    return world.name(static_cast<std::size_t>(object->getUserIndex()));
  };
  return {{"a", name(row.a)},      {"b", name(row.b)},
          {"point", row.point},    {"kind", kKinds[static_cast<int>(row.kind)]},
          {"step", row.step},      {"energy", row.energy},
          {"new", row.isNew},      {"patchNew", row.patchNew},
          {"renamed", row.renamed}};
}

Json madeJson(const EnergyAudit& audit, const World& world) {
  Json made;
  for (const RowKind kind :
       {RowKind::Normal, RowKind::Friction1, RowKind::Friction2, RowKind::Spring}) {
    const EnergyMade& m = audit.made(kind);
    made[kKinds[static_cast<int>(kind)]] = {{"rows", m.rows},
                                            {"energy", m.energy},
                                            {"byNew", m.byNew},
                                            {"worst", worstJson(m.worst, world)}};
  }
  return made;
}

void refuse(const World& world) {
  for (std::size_t i = 0; i < world.bodyCount(); ++i)
    if (world.isSoft(i) || world.isCuttable(i))
      throw BadInput("--audit: body '" + world.name(i) +
                     "' is cut or deforms; only the energy of rigid bodies is audited");
}

Json run(const AuditedScene& scene) {
  const SceneDescription description = loadScene(scene.file);
  const double step = scene.step.value_or(description.step);
  if (scene.seconds / step > kMostSteps)
    throw BadInput("--step: over ten million steps; give a longer --step or fewer --seconds");
  WorldSettings settings;
  settings.common = scene.common;
  settings.iterations = scene.iterations;
  settings.voxel =
      scene.common.voxel ? *scene.common.voxel : defaultVoxel(description, scene.common);
  World world(description, settings);
  refuse(world);
  EnergyAudit audit(world.bullet());
  const long steps = std::max(1L, std::lround(scene.seconds / step));
  double most = 0, mostWithSprings = 0;
  Json each = Json::array();
  for (long n = 0; n < steps; ++n) {
    audit.begin(step);
    world.step(step);
    each.push_back(partsJson(audit.step()));
    const EnergyParts& sum = audit.sum();
    most = std::max(most, sum.bodies);
    mostWithSprings = std::max(mostWithSprings, sum.bodies + sum.springs + sum.found);
  }
  return {{"scene", scene.file},
          {"voxel", settings.voxel},
          {"step", step},
          {"steps", steps},
          {"sum", partsJson(audit.sum())},
          {"most", {{"bodies", most}, {"bodiesAndSprings", mostWithSprings}}},
          {"made", madeJson(audit, world)},
          {"worst", worstJson(audit.worst(), world)},
          {"each", std::move(each)}};
}

void printLine(const char* name, double joules, const char* meaning) {
  std::cout << "  " << std::left << std::setw(10) << name << std::right << std::setw(13) << joules
            << "  " << meaning << '\n';
}

void printSum(const Json& sum) {
  const auto line = [&](const char* name, const char* meaning) {
    printLine(name, sum[name].get<double>(), meaning);
  };
  line("bodies", "kinetic and of gravity, change");
  line("springs", "stored by contacts while bodies move, change");
  line("found", "stored by contacts from step to step, change");
  std::cout << "bodies and springs changed by\n";
  line("friction", "rows of friction");
  line("normals", "normal rows, with their springs");
  line("joints", "joints");
  line("drivers", "bodies that are driven");
  line("solver", "taken by implicit steps");
  line("turning", "bodies that turn");
  line("rest", "none of these");
}

void printWorst(const Json& row) {
  if (row.is_null()) return;
  const char* const since = row["renamed"] ? ", under a new ID" : row["new"] ? ", new" : "";
  std::cout << "             most: " << row["energy"].get<double>() << " in step " << row["step"]
            << ", point " << row["point"] << " of " << row["a"].get<std::string>() << " and "
            << row["b"].get<std::string>() << since << (row["patchNew"] ? ", its patch new" : "")
            << '\n';
}

void print(const Json& j) {
  std::cout << "energy [J] of " << j["steps"] << " steps of " << j["step"] << " s\n";
  printSum(j["sum"]);
  std::cout << "rows that made energy, and springs that were found compressed\n";
  for (const char* kind : kKinds) {
    const Json& made = j["made"][kind];
    std::ostringstream rows;
    rows << made["rows"] << " rows; by new points " << made["byNew"].get<double>();
    printLine(kind, made["energy"].get<double>(), rows.str().c_str());
    printWorst(made["worst"]);
  }
}

}  // namespace

void auditScene(const AuditedScene& scene) {
  makeFolder(scene.out);
  const Json json = run(scene);
  print(json);
  writeWhole("--out", (std::filesystem::path(scene.out) / "audit.json").string(),
             jsonText(json, 1) + '\n');
}

}  // namespace cloudcontact::program::lab
