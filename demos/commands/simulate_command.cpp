// `cloudcontact simulate SCENE.sdf`: runs an SDFormat world or a URDF robot and reports on it.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>

#include "commands/command_tree.h"
#include "commands/commands.h"
#include "commands/explanation.h"
#include "io/interrupt.h"
#include "io/json.h"
#include "io/output_file.h"
#include "io/progress.h"
#include "replay/recorder.h"
#include "replay/replay_file.h"
#include "scene/scene_clouds.h"
#include "scene/scene_file.h"
#include "scene/simulation.h"
#include "view/live_view.h"
#include "view/page_server.h"

namespace cloudcontact::program {
namespace {

constexpr double kRunSeconds = 5;
constexpr double kMostSteps = 1e9;  // weeks of computing, and within int
constexpr double kWatched = 60;     // [s] for the frames of a replay of a run that Ctrl-C ends

struct SimulateOptions {
  CommonOptions common;
  std::string scene, trajectory, replay;
  std::optional<double> seconds, step;
  int substeps = 1;
  std::optional<int> iterations = {};
  bool sleep = false, view = false;
  std::optional<int> port = {};
  std::optional<double> speed = {};
  bool isOpenEnded() const { return view && !seconds; }
};

// The whole file at the end, or none. A view may run for hours, so rows go to the disk once they
// are many; a run that is killed before leaves nothing there.
class Trajectory {
 public:
  explicit Trajectory(std::string file) : name_(std::move(file)) {
    rows_ << "time,body,x,y,z,qx,qy,qz,qw,vx,vy,vz,wx,wy,wz\n" << std::setprecision(9);
  }
  void add(double time, const World& world) {
    for (std::size_t i = 0; i < world.bodyCount(); ++i) {
      if (world.isStatic(i)) continue;
      const BodyState s = world.state(i);
      rows_ << time << ',' << quoted(world.name(i));
      for (const auto& v : {s.pose.position}) numbers(v);
      const auto& q = s.pose.orientation;
      rows_ << ',' << q.x() << ',' << q.y() << ',' << q.z() << ',' << q.w();
      for (const auto& v : {s.linearVelocity, s.angularVelocity}) numbers(v);
      rows_ << '\n';
    }
    if (rows_.tellp() > kMostRows) hand();
  }
  void finish() {
    hand();
    file_->finish();
  }

 private:
  static constexpr std::streamoff kMostRows = 4 << 20;  // [bytes] in memory

  void hand() {
    if (!file_) file_.emplace("--trajectory", name_);
    file_->add(rows_.str());
    rows_.str("");
  }
  static std::string quoted(const std::string& name) {
    if (name.find_first_of(",\"\n") == std::string::npos) return name;
    std::string out = "\"";
    for (char c : name) out += c == '"' ? std::string("\"\"") : std::string(1, c);
    return out + "\"";
  }
  void numbers(const Vec3& v) { rows_ << ',' << v.x() << ',' << v.y() << ',' << v.z(); }

  std::string name_;
  std::optional<OutputFile> file_;
  std::ostringstream rows_;
};

Json bodyJson(const World& world, const SimulationReport& report, std::size_t i) {
  const BodyState& s = report.bodies[i];
  const auto& q = s.pose.orientation;
  return {{"name", world.name(i)},
          {"position", asJson(s.pose.position)},
          {"orientation", {q.x(), q.y(), q.z(), q.w()}},
          {"linearVelocity", asJson(s.linearVelocity)},
          {"angularVelocity", asJson(s.angularVelocity)},
          {"asleep", s.asleep},
          {"turns", asJson(report.turns[i])}};
}

// Of the scene's bodies that can be cut, and of pieces that were cut again.
Json cutJson(const World& world, std::size_t sceneBodies) {
  Json cuts = Json::array();
  for (std::size_t i = 0; i < world.bodyCount(); ++i) {
    const CutRecord& cut = world.cutOf(i);
    if (!world.isCuttable(i) || (i >= sceneBodies && cut.mass == 0)) continue;
    cuts.push_back({{"body", world.name(i)},
                    {"volume", cut.volume},
                    {"mass", cut.mass},
                    {"pieces", cut.pieces},
                    {"gone", cut.gone}});
  }
  return cuts;
}

Json softJson(const World& world) {
  Json soft = Json::array();
  for (std::size_t i = 0; i < world.bodyCount(); ++i) {
    if (!world.isSoft(i)) continue;
    const SoftRecord record = world.softRecord(i);
    soft.push_back({{"body", world.name(i)},
                    {"mass", world.mass(i)},
                    {"nodes", record.nodes},
                    {"links", record.links},
                    {"cutLinks", record.cut},
                    {"pieces", record.pieces}});
  }
  return soft;
}

Json shapesJson(const World& world) {
  Json shapes = Json::array();
  for (const KnownShape& known : world.knownShapes())
    shapes.push_back(
        {{"body", world.name(known.body)}, {"shape", known.kind}, {"error", known.error}});
  return shapes;
}

Json unmeasuredJson(const World& world) {
  Json names = Json::array();
  for (std::size_t i = 0; i < world.bodyCount(); ++i)
    if (!world.isMeasured(i)) names.push_back(world.name(i));
  return names;
}

Json reportJson(const World& world, const SimulationReport& r, const CommonOptions& options,
                std::size_t sceneBodies) {
  std::ostringstream hash;
  hash << std::hex << std::setw(16) << std::setfill('0') << r.hash;
  Json json;
  json["method"] = nameOf(options.method);
  const DeviceUse device = world.deviceUse();
  json["backend"] = nameOf(device.name.empty() ? Backend::Cpu : Backend::OpenCl);
  if (!device.name.empty())
    json["device"] = {{"name", device.name},
                      {"steps", device.steps},
                      {"pairs", device.pairs},
                      {"pairsOnCpu", device.onCpu}};
  json["steps"] = r.steps;
  json["step"] = r.step;
  json["wallSeconds"] = r.wallSeconds;
  json["realTimeFactor"] = r.realTimeFactor;
  json["narrowPhaseSeconds"] = r.narrowPhaseSeconds;
  json["solverSeconds"] = r.solverSeconds;
  json["pairs"] = r.pairs;
  json["contactsPerStep"] = r.contactsPerStep;
  json["maxPenetration"] = r.maxPenetration;
  json["energyStart"] = r.energyStart.ofBodies();
  json["energyEnd"] = r.energyEnd.ofBodies();
  json["energyMax"] = r.energyMax;
  json["springEnergyStart"] = r.energyStart.spring;
  json["springEnergyEnd"] = r.energyEnd.spring;
  json["springEnergyMax"] = r.springEnergyMax;
  json["energyCutAway"] = r.energyEnd.cutAway;
  json["unmeasured"] = unmeasuredJson(world);
  json["cut"] = cutJson(world, sceneBodies);
  json["soft"] = softJson(world);
  json["shapes"] = shapesJson(world);
  if (options.explain) json["explain"] = explanation(world);
  json["hash"] = hash.str();
  json["bodies"] = Json::array();
  for (std::size_t i = 0; i < world.bodyCount(); ++i)
    json["bodies"].push_back(bodyJson(world, r, i));
  return json;
}

void printRun(const Json& j) {
  const auto number = [&](const char* name) { return j[name].get<double>(); };
  std::cout << j["method"].get<std::string>() << ": " << j["steps"] << " steps of "
            << number("step") << " s in " << number("wallSeconds") << " s ("
            << number("realTimeFactor") << " x real time)\n"
            << "  narrow phase  " << number("narrowPhaseSeconds") << " s, solver "
            << number("solverSeconds") << " s\n"
            << "  contacts      " << number("contactsPerStep") << " a step in " << number("pairs")
            << " pairs\n"
            << "  penetration   " << number("maxPenetration") << " m at most\n"
            << "  energy        " << number("energyStart") << " J at the start, "
            << number("energyEnd") << " J at the end, " << number("energyMax") << " J at most\n"
            << "  hash          " << j["hash"].get<std::string>() << '\n';
  for (const Json& c : j["cut"])
    std::cout << "  " << c["body"].get<std::string>() << "  lost " << c["volume"].get<double>()
              << " m^3, " << c["mass"].get<double>() << " kg, and " << c["pieces"] << " pieces\n";
  for (const Json& s : j["soft"])
    std::cout << "  " << s["body"].get<std::string>() << "  has " << s["nodes"] << " nodes, "
              << s["links"] << " links, " << s["cutLinks"] << " cut, " << s["pieces"]
              << (s["pieces"] == 1 ? " piece\n" : " pieces\n");
  for (const Json& b : j["bodies"])
    std::cout << "  " << b["name"].get<std::string>() << "  at " << vectorText(b["position"])
              << "  turned " << vectorText(b["turns"])
              << (b["asleep"].get<bool>() ? "  asleep\n" : "\n");
  if (j.contains("explain")) printExplanation(j["explain"]);
}

void noteUnmeasured(const World& world) {
  const Json names = unmeasuredJson(world);
  if (names.empty()) return;
  std::cerr << "cloudcontact: penetration leaves out " << names.size()
            << (names.size() == 1 ? " body" : " bodies")
            << " without a mesh or an inside, or that can be cut or deform ('"
            << names[0].get<std::string>() << "')\n";
}

// Whether the device that --backend asks for did anything.
void noteDevice(const World& world) {
  const DeviceUse device = world.deviceUse();
  if (!device.failure.empty()) reportCpuFallback(device.failure);
  if (!device.name.empty() && device.steps == 0)
    reportCpuFallback("no step had the " + std::to_string(device.least) +
                      " pairs to search from which a device pays");
}

// Adds the texts of a page to a replay of this world.
Replay described(Replay replay, const World& world, const SceneDescription& scene,
                 const SimulateOptions& options, const WorldSettings& settings,
                 const SimulationReport& r) {
  replay.title = scene.name;
  replay.story = std::filesystem::path(options.scene).filename().string();
  replay.setup = setupText(settings, r.step, options.substeps);
  replay.voxel = usesClouds(options.common.method) ? settings.voxel : 0;
  replay.facts = factsOf(world, r);
  return replay;
}

// Files whose elements state no threshold of their own.
std::vector<std::string> filesOf(const SceneDescription& scene) {
  std::vector<std::string> files;
  for (const SceneBody& body : scene.bodies)
    for (const SceneCollision& collision : body.collisions)
      if (const auto* mesh = std::get_if<SceneMesh>(&collision.geometry))
        if (mesh->thresholds.empty()) files.push_back(mesh->file.string());
  return files;
}

WorldSettings worldSettings(const SceneDescription& scene, const SimulateOptions& options) {
  WorldSettings settings;
  settings.common = options.common;
  settings.iterations = options.iterations;
  settings.sleep = options.sleep;
  settings.voxel = options.common.voxel.value_or(0);
  if (!options.common.voxel) {
    settings.voxel = defaultVoxel(scene, options.common);
    std::cerr << "cloudcontact: voxels of " << settings.voxel << " m (--voxel)\n";
  }
  return settings;
}

void checkRun(const SimulateOptions& options) {
  if (!options.replay.empty()) checkReplay(options.replay);
  if (!options.trajectory.empty()) checkOutput("--trajectory", options.trajectory, {".csv"});
  if (options.port && !options.view) throw BadInput("--port: needs --view beside it");
  if (options.speed && !options.view) throw BadInput("--speed: needs --view beside it");
}

SimulationSettings runSettings(const SceneDescription& scene, const SimulateOptions& options) {
  SimulationSettings run;
  run.step = options.step.value_or(scene.step);
  run.seconds =
      options.isOpenEnded() ? 0.5 * kMostSteps * run.step : options.seconds.value_or(kRunSeconds);
  run.substeps = options.substeps;
  if (run.seconds / run.step > kMostSteps)
    throw BadInput("--step: " + std::to_string(run.seconds) + " s in steps that short are over " +
                   "a thousand million; give a longer --step or fewer --seconds");
  return run;
}

// Runs the world in the browser, in real time.
SimulationReport simulateInView(World& world, const std::string& title,
                                const SimulateOptions& options, const WorldSettings& settings,
                                SimulationSettings run, std::unique_ptr<PageServer> server) {
  const Interrupt interrupt;
  LiveViewSettings page;
  page.speed = options.speed.value_or(1);
  page.step = run.step / run.substeps;
  page.title = title;
  page.setup = setupText(settings, run.step, options.substeps);
  page.voxel = usesClouds(options.common.method) ? settings.voxel : 0;
  LiveView view(world, 0, page, std::move(server));
  std::cerr << "cloudcontact: open " << view.url() << " in a browser; Ctrl-C ends the run"
            << std::endl;
  run.goesOn = [&](double time) { return view.follow(time, [&] { return !interrupt.came(); }); };
  try {
    return simulate(world, run);
  } catch (const std::exception& failure) {
    view.end(failure.what());
    throw;
  }
}

void run(const SimulateOptions& options) {
  checkRun(options);
  checkTogether(options.common);
  const SceneDescription scene = loadScene(options.scene);
  checkThresholds(options.common, filesOf(scene));
  const WorldSettings settings = worldSettings(scene, options);
  SimulationSettings run = runSettings(scene, options);
  // Before the world, which may take a while: a port in use is soon told.
  auto server = options.view ? std::make_unique<PageServer>(options.port.value_or(0)) : nullptr;
  World world(scene, settings);
  noteUnmeasured(world);
  for (const std::string& advice : world.advice()) std::cerr << "cloudcontact: " << advice << '\n';
  std::optional<Trajectory> trajectory;
  if (!options.trajectory.empty()) trajectory.emplace(options.trajectory);
  Recorder recorder;
  if (!options.replay.empty())
    recorder.begin(world, scene.name, options.isOpenEnded() ? kWatched : run.seconds, run.step);
  const auto progress = options.isOpenEnded() ? nullptr : progressBar("simulating " + scene.name);
  run.observe = [&](double time, const World& now) {
    if (trajectory) trajectory->add(time, now);
    if (!options.replay.empty()) recorder.record(time, now);
    if (progress) progress(std::min(1.0, time / run.seconds));
  };
  const SimulationReport report =
      server ? simulateInView(world, scene.name, options, settings, run, std::move(server))
             : simulate(world, run);
  noteDevice(world);
  if (progress) progress(1);  // in case rounding leaves the last time below 1
  if (trajectory) trajectory->finish();
  if (!options.replay.empty()) {
    recorder.close(world);
    saveReplay(described(recorder.finish(), world, scene, options, settings, report),
               options.replay);
  }
  const Json json = reportJson(world, report, options.common, scene.bodies.size());
  if (options.common.json)
    std::cout << jsonText(json) << '\n';
  else
    printRun(json);
}

void addOptions(CLI::App& command, SimulateOptions& o) {
  const auto text = [&](const char* name, const char* help, const char* type, auto reader) {
    command.add_option_function<std::string>(name, reader, help)->type_name(type);
  };
  addPositive(command, "--seconds", "simulated time [s] (default 5; with --view, until Ctrl-C)",
              "S", [&o](double v) { o.seconds = v; });
  addPositive(command, "--step", "length of a step [s]; the scene's <max_step_size> if not given",
              "H", [&o](double v) { o.step = v; });
  text("--substeps", "parts of each step (default 1)", "N",
       [&o](const std::string& t) { o.substeps = readCount("--substeps", t, 1, 10000); });
  text("--iterations",
       "iterations of the solver per step (default: clouds as many as it takes, others 10)", "N",
       [&o](const std::string& t) { o.iterations = readCount("--iterations", t, 1, 100000); });
  text("--trajectory", "CSV file for every body's state after every step", "OUT.csv",
       [&o](const std::string& t) { o.trajectory = t; });
  text("--replay", "file for a replay: animated glTF, or a page for any browser",
       "OUT.glb|OUT.html", [&o](const std::string& t) { o.replay = t; });
  command.add_flag("--view", o.view,
                   "show the run in a browser while it goes on, in real time: prints an address of "
                   "this machine; pause, step, drag bodies, cut");
  text("--port", "with --view: port of 127.0.0.1 (default: a free one)", "N",
       [&o](const std::string& t) { o.port = readCount("--port", t, 1, 65535); });
  text("--speed", "with --view: times real time (default 1); 0: as fast as it can", "X",
       [&o](const std::string& t) { o.speed = readNotNegative("--speed", t); });
  text("--reuse",
       "relative motion of a pair up to which its contact is moved instead of searched [voxels] "
       "(default 0.02); 0: never",
       "VOXELS", [&o](const std::string& t) { o.common.reuse = readNotNegative("--reuse", t); });
  command.add_flag("--explain", o.common.explain,
                   "what was modelled of each pair of clouds, what was left out, and its cost");
  command.add_flag("--sleep", o.sleep, "let bodies at rest fall asleep");
}

}  // namespace

void addSimulateCommand(CLI::App& app) {
  auto options = std::make_shared<SimulateOptions>();
  CLI::App& command = *app.add_subcommand(
      "simulate",
      "run an SDFormat world, or a robot of URDF.\n"
      "Energy is that of the bodies, kinetic and of gravity (zero at the world's origin), without\n"
      "the springs of contacts. A pair's friction is the smaller mu of its bodies; a body without\n"
      "mu takes the other's, and without both there is no friction. Bodies without a mass have\n"
      "the density of water.");
  command.add_option("SCENE", options->scene, "an SDFormat world (.sdf), or a robot (.urdf)")
      ->required();
  addOptions(command, *options);
  addBodyOptions(command, options->common);
  addLawOptions(command, options->common);
  addFrictionOption(command, options->common);
  addTissueOptions(command, options->common, "none if not given");
  addMethodOption(command, options->common);
  addSamplesOption(command, options->common);
  addToleranceOption(command, options->common);
  addPaperOptions(command, options->common);
  addBackendOption(command, options->common);
  addCacheOption(command, options->common);
  addRunOptions(command, options->common);
  addExamples(
      command,
      {"cloudcontact simulate scene.sdf --voxel 0.001 --seconds 0.1 --replay run.html",
       "cloudcontact simulate scene.sdf --voxel 0.001 --seconds 0.1 --json --trajectory run.csv",
       "cloudcontact simulate scene.sdf --voxel 0.001 --seconds 0.1 --view --speed 0.5"});
  command.callback([options] { run(*options); });
}

}  // namespace cloudcontact::program
