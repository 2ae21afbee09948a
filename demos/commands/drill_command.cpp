// `cloudcontact drill WORKPIECE`: a tool in a simulated hand cuts straight into a body and comes
// out again. Reports force and removed volume, and saves the remaining body.
#include <cloudcontact/voxels/cloud_file.h>
#include <CLI/CLI.hpp>

#include <cmath>
#include <iostream>
#include <memory>
#include <numbers>
#include <sstream>

#include "commands/command_tree.h"
#include "commands/commands.h"
#include "draw/cut_picture.h"
#include "draw/force_chart.h"
#include "draw/picture_file.h"
#include "io/json.h"
#include "io/output_file.h"
#include "io/progress.h"
#include "io/text.h"
#include "scene/body.h"
#include "scene/cutting_figures.h"
#include "scene/tissue_file.h"

namespace cloudcontact::program {

namespace {

constexpr double kSpindle = 300000 / 60.0;  // [1/s], of --edge-speed's default
constexpr double kLeastTool = 2;            // least half width of the tool [voxels]
constexpr double kMostTicks = 5e6;
constexpr double kBack = 5;  // times the speed on the way out

struct DrillOptions {
  CommonOptions common;
  std::string body, bur = "sphere:0.0006";
  std::optional<Pose> from, to;
  double seconds = 5, step = 1e-3, efficiency = 0.1;
  std::optional<double> edgeSpeed;
  std::string output, force, picture, chart;
};

// The tool with its least and greatest half width [m].
struct Bur {
  PlacedSolid area;
  double least = 0, most = 0;
};

Bur burOf(const DrillOptions& o, double voxel) {
  const Body body = readBody(o.bur, o.common);
  if (isHalfSpace(body))
    throw BadInput("--bur: a halfspace is no tool; give a sphere, box or file");
  Bur bur;
  const Vec3 half = boundsOf(body).sizes() / 2;
  bur.least = half.minCoeff(), bur.most = half.maxCoeff();
  if (bur.least < kLeastTool * voxel)
    throw BadInput("--bur: " + o.bur + " is thinner than four voxels; give a --voxel of at most " +
                   numberText(1e6 * bur.least / kLeastTool) + "e-6 or a larger bur");
  bur.area = solidOf(body, voxel, o.common);
  return bur;
}

// The default path runs from above the body's middle to four half widths of the tool below its top.
PlannedPath pathOf(const DrillOptions& o, const Cloud& cloud, const Bur& bur) {
  Eigen::AlignedBox3d bounds;
  const Eigen::Vector3i size = cloud.size();
  for (int z = 0; z < size.z(); ++z)
    for (int y = 0; y < size.y(); ++y)
      for (int x = 0; x < size.x(); ++x)
        if (cloud.coverage(x, y, z) > 127) bounds.extend(cloud.center(x, y, z));
  const Vec3 top(bounds.center().x(), bounds.center().y(), bounds.max().z());
  const Vec3 from = o.from ? o.from->position : Vec3(top + Vec3(0, 0, 1.5 * bur.most));
  const Vec3 to = o.to ? o.to->position : Vec3(top - Vec3(0, 0, 4 * bur.most));
  const double way = (to - from).norm();
  if (!(way > 0)) throw BadInput("--to: is the same place as --from; give another");
  if (boundsOf(bur.area).translated(from).intersects(bounds)) {
    for (int z = 0; z < size.z(); ++z)
      for (int y = 0; y < size.y(); ++y)
        for (int x = 0; x < size.x(); ++x)
          if (cloud.coverage(x, y, z) > 127 && depthOf(bur.area, cloud.center(x, y, z) - from) > 0)
            throw BadInput("--from: the tool intersects the body there; give a place outside");
  }
  const double speed = way / o.seconds;
  return PlannedPath({{from, 1, 0}, {to, speed, 0.1}, {from, kBack * speed, 0}});
}

CuttingTask taskOf(const DrillOptions& o, const Cloud& cloud, const Bur& bur) {
  CuttingTask task{{}, {}, pathOf(o, cloud, bur), {}, {}};
  if (task.path.seconds() / o.step > kMostTicks)
    throw BadInput(
        "--step: makes more than 5,000,000 ticks; give a longer step or fewer --seconds");
  task.haptic.tool.area = bur.area;
  task.haptic.step = o.step;
  task.haptic.handStiffness = 5000;
  task.haptic.handDamping = 0.5 * 5000 * o.step;
  task.haptic.cutter =
      Cutter{17e9, o.efficiency, o.edgeSpeed.value_or(2 * std::numbers::pi * kSpindle * bur.least)};
  task.orientation = Eigen::Quaterniond::Identity();
  task.hand = {0.1, 5000, 20, 0, std::max(1, static_cast<int>(std::ceil(o.step / 1e-4)))};
  task.progress = progressBar("drilling " + o.body);
  return task;
}

std::string forceCsv(const CuttingRun& run) {
  std::ostringstream csv;
  csv.precision(9);
  csv << "time,x,y,z,toolX,toolY,toolZ,forceX,forceY,forceZ,depth,cutVolume,workVolume,energy";
  for (const std::string& name : run.tissues) csv << ",share:" << printable(name);
  csv << '\n';
  for (std::size_t k = 0; k < run.ticks.size(); ++k) {
    const CuttingTick& t = run.ticks[k];
    csv << t.time;
    for (const Vec3* v : {&t.hand, &t.tool, &t.force})
      for (int i = 0; i < 3; ++i) csv << ',' << (*v)[i];
    csv << ',' << t.depth << ',' << t.cut << ',' << t.work << ',' << t.energy;
    for (const float share : run.sharesAt(k)) csv << ',' << share;
    csv << '\n';
  }
  return csv.str();
}

Json resultJson(const CuttingRun& run, const Cloud& before, const BaseVectorField& field,
                const Cloud& after) {
  const CuttingFigures f = figuresOf(run);
  Json json;
  json["voxelSize"] = before.voxelSize();
  json["step"] = run.step;
  json["ticks"] = run.ticks.size();
  json["mostForce"] = f.mostForce;
  json["largestStep"] = {{"touching", f.largestStep}, {"cutting", f.largestCuttingStep}};
  json["cutVolume"] = f.cutVolume;
  json["workVolume"] = f.workVolume;
  json["cutMass"] = run.massBefore - run.massAfter;
  json["energy"] = run.ticks.back().energy;
  json["leastEnergy"] = run.leastEnergy;
  const std::vector<double> was = materialVolumes(before), is = materialVolumes(after);
  json["tissues"] = Json::array();
  for (std::size_t t = 0; t < f.tissues.size(); ++t) {
    const TissueFigures& tissue = f.tissues[t];
    Json entry = {{"name", tissue.name}, {"cutVolume", was[t] - is[t]}};
    entry["firstTouch"] = tissue.firstTouch ? Json(*tissue.firstTouch) : Json();
    entry["seconds"] = tissue.seconds;
    entry["meanForce"] = tissue.meanForce;
    json["tissues"].push_back(entry);
  }
  json["hash"] = field.hash();
  json["microseconds"] = {{"median", f.medianMicroseconds}, {"p99", f.p99Microseconds}};
  return json;
}

void printDrilling(const std::string& body, const Json& j) {
  std::cout << body << " in voxels of " << lengthText(j["voxelSize"].get<double>()) << ", "
            << j["ticks"] << " ticks of " << timeText(j["step"].get<double>()) << '\n'
            << "  greatest force " << forceText(j["mostForce"].get<double>()) << '\n'
            << "  cut away       " << volumeText(j["cutVolume"].get<double>())
            << " (Archard's law: " << volumeText(j["workVolume"].get<double>()) << ")\n"
            << "  energy given   " << energyText(j["energy"].get<double>()) << '\n'
            << "  a tick         " << timeText(1e-6 * j["microseconds"]["median"].get<double>())
            << ", 99 % within " << timeText(1e-6 * j["microseconds"]["p99"].get<double>()) << '\n';
  for (const Json& t : j["tissues"]) {
    std::cout << "  " << printable(t["name"].get<std::string>()) << ": ";
    if (t["firstTouch"].is_null()) {
      std::cout << "not touched\n";
      continue;
    }
    std::cout << "touched at " << timeText(t["firstTouch"].get<double>()) << ", "
              << volumeText(t["cutVolume"].get<double>()) << " removed";
    if (t["seconds"].get<double>() > 0)
      std::cout << ", " << forceText(t["meanForce"].get<double>()) << " on average";
    std::cout << '\n';
  }
}

void checkFiles(const DrillOptions& o) {
  if (!o.output.empty()) checkOutput("-o", o.output, {".cloud"});
  if (!o.force.empty()) checkOutput("--force", o.force, {".csv"});
  if (!o.chart.empty()) checkOutput("--chart", o.chart, {".png", ".svg"});
  if (!o.picture.empty()) checkPicture(o.picture);
}

void save(const DrillOptions& o, const CuttingRun& run, const Cloud& before, const Cloud& after) {
  const std::string name = shortName(o.body);
  std::ostringstream below;
  below << lengthText(before.voxelSize()) << " voxels, "
        << volumeText(run.volumeBefore - run.volumeAfter) << " removed by " << o.bur;
  if (!o.force.empty()) writeWhole("--force", o.force, forceCsv(run));
  const Vec3 way = run.ticks.front().hand;
  Vec3 farthest = way;
  for (const CuttingTick& t : run.ticks)
    if ((t.hand - way).norm() > (farthest - way).norm()) farthest = t.hand;
  if (!o.chart.empty())
    savePicture(forceChart(run, {"Force on the hand while drilling " + name, below.str(),
                                 (farthest - way).stableNormalized(),
                                 "Depth of the tool below its first contact [mm]"}),
                o.chart);
  if (!o.picture.empty())
    savePicture(cutPicture(before, after, {name + ", drilled", below.str(), run.tissues, true}),
                o.picture);
  if (o.output.empty()) return;
  try {
    saveCloud(after, o.output);
  } catch (const std::runtime_error& error) {
    throw BadInput(std::string("-o: ") + error.what());
  }
}

void run(const DrillOptions& o) {
  checkFiles(o);
  const std::string& chosen = o.common.tissues.table;
  const TissueTable table = readTissues("--tissues", chosen, o.common.stiffness.value_or(2e4));
  if (o.common.stiffness && chosen != "dental")
    throw BadInput("--stiffness: applies to enamel of the dental table; write it into " + chosen);
  checkThresholds(o.common, {o.body, o.bur});
  const Body body = readBody(o.body, o.common);
  const double voxel = o.common.voxel.value_or(defaultVoxel(body));
  const Bur bur = burOf(o, voxel);
  const Cloud before = digitizeBody(body, voxel, o.common).cloud;
  const TissueTable tissues =
      tissuesOfParts(o.body, table, before.materials(), o.common.tissues.ofParts);
  const CuttingTask task = taskOf(o, before, bur);
  CuttingRun cut;
  TissueTable named = tissues;  // parts may share a tissue, so use the parts' names
  if (!before.materials().empty())
    for (std::size_t t = 0; t < named.size(); ++t) named[t].name = before.materials()[t];
  BaseVectorField field(before, named, sphereWindow(before.voxelSize()));
  cut = runCutting(field, task);
  for (std::size_t t = 0; t < tissues.size(); ++t)
    if (!before.materials().empty() && tissues[t].name != named[t].name)
      cut.tissues[t] = tissues[t].name + " (" + named[t].name + ")";
    else
      cut.tissues[t] = tissues[t].name;
  const Cloud after = field.cloud();
  save(o, cut, before, after);
  const Json json = resultJson(cut, before, field, after);
  if (o.common.json)
    std::cout << jsonText(json) << '\n';
  else
    printDrilling(o.body, json);
}

void addPlaces(CLI::App& command, DrillOptions& o) {
  const auto place = [&](const char* name, std::optional<Pose>& pose, const char* help) {
    command
        .add_option_function<std::string>(
            name, [name, &pose](const std::string& t) { pose = readPose(name, t); }, help)
        ->type_name("\"x y z\"");
  };
  place("--from", o.from, "start of the tool's origin [m]; above the body if not given");
  place("--to", o.to, "end of its path [m]; two tools deep if not given");
  const auto number = [&](const char* name, auto& value, const char* help) {
    addPositive(command, name, help, "NUMBER", [&value](double v) { value = v; });
  };
  number("--seconds", o.seconds, "time for the way in [s] (default 5); the way out takes a fifth");
  number("--step", o.step, "time between ticks [s] (default 0.001)");
  number("--stiffness", o.common.stiffness,
         "of enamel in the dental table [N/m] (default 2e4); the others follow");
  number("--edge-speed", o.edgeSpeed,
         "speed of the tool's edge [m/s]; that of 300,000 rpm if not given");
  command
      .add_option_function<std::string>(
          "--efficiency",
          [&o](const std::string& t) {
            o.efficiency = readPositive("--efficiency", t);
            if (o.efficiency > 1) throw BadInput("--efficiency: must be 1 at most");
          },
          "removed share of the plowed volume (default 0.1)")
      ->type_name("NUMBER");
}

}  // namespace

void addDrillCommand(CLI::App& app) {
  auto options = std::make_shared<DrillOptions>();
  CLI::App& command = *app.add_subcommand(
      "drill", "cut into a body with a tool in a simulated hand: force, volume, remaining body");
  command.add_option("WORKPIECE", options->body, "mesh file, CT volume, .cloud file or primitive")
      ->required();
  command
      .add_option("--bur", options->bur,
                  "the tool: sphere:R (default sphere:0.0006), a box or a file")
      ->type_name("BODY");
  options->common.tissues.table = "dental";
  addTissueOptions(command, options->common, "dental if not given");
  addPlaces(command, *options);
  command.add_option("--force", options->force, "file for force and position of every tick")
      ->type_name("OUT.csv");
  command
      .add_option("--chart", options->chart, "file for a chart of the force over time by tissue")
      ->type_name("OUT.svg|OUT.png");
  command
      .add_option("--picture", options->picture,
                  "file for a picture of the remaining body, cut open")
      ->type_name("OUT.svg|OUT.png");
  command.add_option("-o,--output", options->output, "file for the remaining cloud")
      ->type_name("OUT.cloud");
  addBodyOptions(command, options->common);
  addRunOptions(command, options->common);
  addExamples(command, {"cloudcontact drill tooth.obj --unit mm --voxel 0.0005 --tissue all=dentin "
                        "--force force.csv"});
  command.callback([options] { run(*options); });
}

}  // namespace cloudcontact::program
