// `cloudcontact tune A B --pose POSE | SCENE.sdf --tolerance T`: the settings of clouds that hold a
// tolerance, and what one step finer or coarser would cost.
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include "commands/command_tree.h"
#include "commands/commands.h"
#include "commands/contact_report.h"
#include "io/json.h"
#include "io/text.h"
#include "scene/scene_file.h"
#include "scene/trials.h"

namespace cloudcontact::program {

namespace {

// [voxels] CloudContactSettings::reuseMotion: up to kMostReuse, of half of what the tolerance
// leaves.
constexpr double kMostReuse = 0.02, kLeastReuse = 0.001;
constexpr double kTrialSeconds = 0.5;

struct TuneOptions {
  CommonOptions common;
  std::string first, second;  // A and B, or a scene and nothing
  std::string pose;
  std::optional<double> seconds;
};

bool isScene(const TuneOptions& options) {
  std::string extension = std::filesystem::path(options.first).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".sdf" || extension == ".world";
}

Trials trialsOf(const TuneOptions& options) {
  if (isScene(options)) {
    if (!options.second.empty() || !options.pose.empty())
      throw BadInput("tune: a scene stands alone; leave out " +
                     (options.second.empty() ? std::string("--pose") : options.second));
    return sceneTrials(loadScene(options.first), options.seconds.value_or(kTrialSeconds),
                       options.common);
  }
  if (options.second.empty())
    throw BadInput("tune: needs A and B with --pose, or one scene that ends in .sdf");
  if (options.pose.empty()) throw BadInput("--pose: say where B is; A is at the origin");
  if (std::holds_alternative<Rigid>(options.common.law) || isViscoelastic(options.common.law))
    throw BadInput("--law: a pair has no steps; use paper or foundation");
  if (options.seconds) throw BadInput("--seconds: a pair does not run; leave it out");
  checkThresholds(options.common, {options.first, options.second});
  const Body a = readBody(options.first, options.common),
             b = readBody(options.second, options.common);
  if (isHalfSpace(a) && isHalfSpace(b))
    throw BadInput("halfspace: two half-spaces have no contact to find; make A or B a body");
  return pairTrials(a, b, readPose("--pose", options.pose), pairLaw(options.common),
                    options.common);
}

Json finite(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

double reuseWithin(double tolerance, const Trial& chosen) {
  const double room = 0.5 * (tolerance - chosen.predicted()) / chosen.setting.voxel;
  return room < kLeastReuse ? 0 : std::min(kMostReuse, room);
}

Json stepJson(const std::optional<Trial>& step, const std::optional<Trial>& truth) {
  if (!step) return {};
  Json json;
  json["error"] = truth ? finite(step->measured(*truth)) : Json();
  json["microseconds"] = step->microseconds;
  json["voxel"] = step->setting.voxel;
  json["samples"] = step->setting.samples;
  json["predictedError"] = finite(step->predicted());
  json["bytes"] = step->bytes;
  return json;
}

Json tunedJson(double tolerance, const Tuned& tuned) {
  const Trial& chosen = tuned.chosen;
  Json json;
  json["tolerance"] = tolerance;
  json["chosen"] = {{"voxel", chosen.setting.voxel},
                    {"samples", chosen.setting.samples},
                    {"level", chosen.level},
                    {"reuse", reuseWithin(tolerance, chosen)}};
  json["predictedError"] = chosen.predicted();
  json["measuredError"] = tuned.reference ? finite(chosen.measured(*tuned.reference)) : Json();
  json["microseconds"] = chosen.microseconds;
  json["bytes"] = chosen.bytes;
  json["places"] = chosen.depths.size();
  json["finer"] = stepJson(tuned.finer, tuned.reference);
  json["coarser"] = stepJson(tuned.coarser, tuned.reference);
  return json;
}

std::string micrometers(const Json& error) {
  char text[32];
  if (error.is_null()) return "      -";
  std::snprintf(text, sizeof text, "%7.3g", 1e6 * error.get<double>());
  return text;
}

void printRow(const char* name, const Json& row, const Json& measured) {
  if (row.is_null()) return;
  char text[128];
  std::snprintf(text, sizeof text, "  %-8s %10.4g %8zu %s %s %10.1f %9.2f\n", name,
                1e6 * row["voxel"].get<double>(), row["samples"].get<std::size_t>(),
                micrometers(row["predictedError"]).c_str(), micrometers(measured).c_str(),
                row["microseconds"].get<double>(), 1e-6 * row["bytes"].get<double>());
  std::cout << text;
}

void printChoice(const Json& j, bool scene) {
  std::cout << "tolerance " << lengthText(j["tolerance"].get<double>()) << "\n"
            << "           voxel[um]  samples   error[um]       "
            << (scene ? "us/step" : "us/query") << "        MB\n"
            << "                             stated  found\n";
  Json chosen = j;
  chosen["voxel"] = j["chosen"]["voxel"];
  chosen["samples"] = j["chosen"]["samples"];
  printRow("coarser", j["coarser"], j["coarser"].is_null() ? Json() : j["coarser"]["error"]);
  printRow("chosen", chosen, j["measuredError"]);
  printRow("finer", j["finer"], j["finer"].is_null() ? Json() : j["finer"]["error"]);
  char options[128];
  std::snprintf(options, sizeof options, "  --voxel %.4g --samples %zu",
                j["chosen"]["voxel"].get<double>(), j["chosen"]["samples"].get<std::size_t>());
  std::cout << options;
  if (scene && j["chosen"]["reuse"].get<double>() < kMostReuse)
    std::cout << " --reuse " << j["chosen"]["reuse"].get<double>();
  std::cout << '\n';
}

// Says how far the search has come; a trial may take a minute.
std::function<Trial(const TuneSetting&)> telling(
    const std::function<Trial(const TuneSetting&)>& attempt) {
  return [attempt](const TuneSetting& setting) {
    const Trial trial = attempt(setting);
    const double stated = trial.predicted();
    std::cerr << "cloudcontact: voxels of " << lengthText(setting.voxel) << ": "
              << (std::isfinite(stated) ? lengthText(stated) + " stated\n" : "no contact\n");
    return trial;
  };
}

void run(const TuneOptions& options) {
  if (!(options.common.tolerance > 0))
    throw BadInput("--tolerance: say what error is tolerable [m]");
  checkTogether(options.common);
  const Trials trials = trialsOf(options);
  const Tuned tuned = tune(options.common.tolerance, trials.limits, telling(trials.attempt));
  if (!tuned.reference)
    std::cerr << "cloudcontact: not measured: "
              << (trials.limits.fixed ? "a saved cloud has no finer voxels\n"
                                      : "voxels half as wide do not fit in memory\n");
  const Json json = tunedJson(options.common.tolerance, tuned);
  if (options.common.json)
    std::cout << jsonText(json) << '\n';
  else
    printChoice(json, isScene(options));
}

void addOwnOptions(CLI::App& command, const std::shared_ptr<TuneOptions>& options) {
  command.add_option("A", options->first, "a body as in contact, or an SDFormat world (.sdf)")
      ->required();
  command.add_option("B", options->second, "as A; not with a world");
  command.add_option("--pose", options->pose, "of B: \"x y z\" or \"x y z qx qy qz qw\" [m]")
      ->type_name("POSE");
  command
      .add_option_function<std::string>(
          "--tolerance",
          [options](const std::string& text) {
            options->common.tolerance = readPositive("--tolerance", text);
          },
          "error of a depth that is tolerable [m]")
      ->type_name("T")
      ->required();
  addPositive(command, "--seconds",
              "of a world: simulated time from which poses are taken [s] (default 0.5)", "S",
              [options](double v) { options->seconds = v; });
}

}  // namespace

void addTuneCommand(CLI::App& app) {
  auto options = std::make_shared<TuneOptions>();
  CommonOptions& common = options->common;
  CLI::App& command = *app.add_subcommand("tune",
                                          "find the voxels and samples that hold a tolerance at "
                                          "the least cost, for a pair or a scene.\n"
                                          "The error of a depth is stated by the contacts "
                                          "themselves, and measured against voxels half\n"
                                          "as wide. Lists one step finer and coarser.");
  addOwnOptions(command, options);
  addBodyOptions(command, common);
  command.remove_option(command.get_option("--voxel"));
  addLawOptions(command, common);
  addTissueOptions(command, common, "none if not given");
  addCacheOption(command, common);
  addRunOptions(command, common);
  addExamples(
      command,
      {R"(cloudcontact tune bolt.stl nut.stl --unit mm --pose "0 0 0.0078" --tolerance 0.0002)"});
  command.callback([options] { run(*options); });
}

}  // namespace cloudcontact::program
