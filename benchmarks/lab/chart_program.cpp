// The program cloudcontact-chart, started by `cloudcontact chart`: runs the laboratory's cases, or
// a pair of the user's, or audits the energy of a scene.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "commands/command_line.h"
#include "commands/command_tree.h"
#include "commands/common_options.h"
#include "io/errors.h"
#include "io/progress.h"
#include "lab/audited_scene.h"
#include "lab/case_bodies.h"
#include "lab/families.h"
#include "lab/lab_results.h"
#include "lab/self_check.h"
#include "scene/body.h"

namespace cloudcontact::program {
namespace {

struct ChartOptions {
  CommonOptions common;
  std::string a, b, pose, only;
  std::string out = "bench-results";
  std::string method;
  bool quick = false, noStability = false, noAccuracy = false;
  std::string trials;
  std::optional<int> iterations = {};
  std::string audit;
  std::optional<double> seconds = {}, step = {};
};

lab::LabBody labBody(const std::string& specification, const CommonOptions& options) {
  const Body body = readBody(specification, options);
  if (!body.mesh && !body.shape)
    throw BadInput(specification + ": peers need a mesh or a primitive; give one");
  if (isHalfSpace(body)) return {specification, {}, body.shape, true, {}};
  return {specification,
          [body](double tolerance) { return meshOf(body, tolerance); },
          body.shape,
          body.shape.has_value(),
          {}};
}

// 32 times the given voxel; by default 16 times the voxel that `cloudcontact contact` would use.
double sizeOf(const ChartOptions& options) {
  if (options.common.voxel) return 32 * *options.common.voxel;
  double voxel = 1e300;
  for (const std::string& name : {options.a, options.b}) {
    const Body body = readBody(name, options.common);
    if (!isHalfSpace(body)) voxel = std::min(voxel, defaultVoxel(body));
  }
  return 16 * voxel;
}

lab::LabCase ownPair(const ChartOptions& options) {
  const Pose pose = readPose("--pose", options.pose);
  const lab::LabBody a = labBody(options.a, options.common), b = labBody(options.b, options.common);
  lab::LabCase own;
  own.family = own.name = options.a + " and " + options.b;
  own.size = sizeOf(options);
  own.convex = a.convex && b.convex;
  own.make = [=](std::uint64_t seed) {
    lab::Random random(seed);
    lab::Instance instance{a, b, {{pose, {}}}};
    instance.a.grid = random.grid(own.size / 32), instance.b.grid = random.grid(own.size / 32);
    return instance;
  };
  return own;
}

void checkMethod(const std::string& method) {
  if (method.empty()) return;
  std::string names;
  for (const lab::LabMethod& m : lab::chartMethods({})) {
    if (m.method == method) return;
    if (names.find(m.method) == std::string::npos) names += (names.empty() ? "" : ", ") + m.method;
  }
  throw BadInput("--method: '" + method + "' is not known; use one of " + names);
}

void audit(const ChartOptions& options) {
  if (!options.a.empty() || !options.b.empty() || !options.pose.empty())
    throw BadInput("--audit: takes a scene; leave A, B and --pose out");
  if (options.quick || options.noStability || options.noAccuracy || !options.only.empty() ||
      !options.method.empty() || !options.trials.empty())
    throw BadInput(
        "--audit: takes --seconds, --step, --voxel, --unit and --out; leave the others out");
  lab::AuditedScene scene;
  scene.file = options.audit, scene.common = options.common, scene.out = options.out;
  scene.step = options.step, scene.iterations = options.iterations;
  scene.seconds = options.seconds.value_or(scene.seconds);
  lab::auditScene(scene);
}

void run(const ChartOptions& options, const std::string& command) {
  if (!options.audit.empty()) return audit(options);
  if (options.seconds || options.step)
    throw BadInput(std::string(options.step ? "--step" : "--seconds") +
                   ": is for the audit of a scene; give --audit with it");
  if (options.a.empty() != options.b.empty() || options.b.empty() != options.pose.empty())
    throw BadInput(
        "chart: for a pair of your own give A, B and --pose; for the reference cases none of them");
  if (options.a.empty() && (options.common.voxel || options.common.metersPerUnit != 1))
    throw BadInput(std::string(options.common.voxel ? "--voxel" : "--unit") +
                   ": is for a pair of your own; give A, B and --pose with it");
  if (options.noAccuracy && (options.noStability || !options.a.empty()))
    throw BadInput("--no-accuracy: nothing would be measured; leave it out");
  checkMethod(options.method);
  std::optional<lab::LabCase> own;
  if (!options.a.empty()) own = ownPair(options);
  const bool made = lab::makeFolder(options.out);
  const auto start = std::chrono::steady_clock::now();
  lab::LabResults results;
  results.quick = options.quick, results.command = command;
  lab::ChartSettings chart;
  chart.quick = options.quick, chart.only = options.only;
  chart.method = options.method;
  chart.progress = progressBar("error against time");
  chart.threads = std::max(2, int(std::thread::hardware_concurrency()));
  results.methods = lab::chartMethods(chart);
  if (own) {
    results.subject = own->name;
    results.chart = lab::runChart(*own, chart);
  } else {
    if (!options.noAccuracy) results.chart = lab::runChart(chart);
    lab::StabilitySettings stability;
    stability.quick = options.quick, stability.only = options.only;
    stability.method = options.method;
    stability.trials = options.trials, stability.iterations = options.iterations;
    stability.progress = progressBar("stability");
    stability.threads = chart.threads;
    if (!options.noStability) results.stability = lab::runStability(stability);
  }
  if (results.chart.empty() && results.stability.empty()) {
    std::error_code ignored;
    if (made) std::filesystem::remove(options.out, ignored);
    throw BadInput("--only: nothing that this would run is called '" + options.only +
                   "'; give a part of the name of a case, a family or a scene");
  }
  results.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  results.faults = lab::ownFaults(results.chart, results.stability);
  const std::string files = lab::writeResults(results, options.out);
  for (const std::string& line : lab::advice(results.chart)) std::cout << line << '\n';
  for (const std::string& fault : results.faults) std::cout << "misses an aim: " << fault << '\n';
  std::cout << "written to " << options.out << ": " << files << '\n';
}

void addOptions(CLI::App& command) {
  auto options = std::make_shared<ChartOptions>();
  command.add_option("A", options->a, "mesh file or primitive; without it the reference cases");
  command.add_option("B", options->b, "the same");
  command.add_option("--pose", options->pose, "pose of B: \"x y z\" or \"x y z qx qy qz qw\" [m]")
      ->type_name("POSE");
  command.add_option("--out", options->out, "output folder (default bench-results)")
      ->type_name("DIR");
  command.add_flag("--quick", options->quick, "fewer cases, grids and scenes: about three minutes");
  command
      .add_option("--only", options->only, "cases, families and scenes whose names contain this")
      ->type_name("TEXT");
  command
      .add_option("--method", options->method,
                  "this method alone: cloud, paper, primitive, gjk, gimpact, hacd, sdf, fcl, ode, "
                  "mujoco")
      ->type_name("METHOD");
  command.add_flag("--no-stability", options->noStability, "without the stability scenes");
  command.add_flag("--no-accuracy", options->noAccuracy, "without the cases of error against time");
  command
      .add_option("--audit", options->audit,
                  "run this scene instead, and tell where its energy goes and which rows of the "
                  "solver make some; its steps are in audit.json")
      ->type_name("SCENE.sdf");
  addPositive(command, "--seconds", "simulated time of --audit [s] (default 5)", "S",
              [&o = *options](double v) { o.seconds = v; });
  addPositive(command, "--step", "step of --audit [s]; the scene's <max_step_size> if not given",
              "H", [&o = *options](double v) { o.step = v; });
  // Hidden, for work on the scenes: selects single trials, and changes the solver's iterations.
  command
      .add_option("--trials", options->trials,
                  "trials whose names contain this: \"cloud 60 stiff\"")
      ->group("");
  command
      .add_option("--iterations", options->iterations,
                  "solver iterations in every trial, or of --audit")
      ->check(CLI::Range(1, 100000))
      ->group("");
  addFileOptions(command, options->common);
  addExamples(command, chartExamples());
  command.callback([options] {
    run(*options, options->quick ? "cloudcontact chart --quick" : "cloudcontact chart");
  });
}

}  // namespace
}  // namespace cloudcontact::program

int main(int argc, char** argv) {
  CLI::App app(
      "Measures speed, accuracy and stability beside other libraries; or charts a pair of your\n"
      "own, with the finest voxels as the reference.",
      "cloudcontact chart");
  return cloudcontact::program::runCommandLine(argc, argv, app, cloudcontact::program::addOptions);
}
