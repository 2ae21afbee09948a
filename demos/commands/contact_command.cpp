// `cloudcontact contact A B --pose POSE`: contacts and force between two bodies, and the time to
// find them.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <tuple>

#include "commands/command_tree.h"
#include "commands/commands.h"
#include "commands/contact_report.h"
#include "draw/contact_picture.h"
#include "draw/picture_file.h"
#include "io/both.h"
#include "io/json.h"

namespace cloudcontact::program {

namespace {

constexpr double kPaperStiffness = 1e4;       // [N/m]
constexpr double kFoundationStiffness = 1e9;  // [N/m^3]
constexpr int kMostRepeats = 1000000;

struct ContactOptions {
  CommonOptions common;
  std::string a, b;
  std::string pose, velocity;
  std::optional<std::string> picture;  // a file
  int repeat = 100;
};

// Reads D of A or B, from --area-a or --area-b.
std::optional<PlacedSolid> readArea(const char* option, const std::string& text, const Body& owner,
                                    double voxel, const CommonOptions& common) {
  if (text.empty()) return {};
  if (isHalfSpace(owner))
    throw BadInput(std::string(option) + ": a half-space detects with all of itself; leave it out");
  const Body area = readBody(text, common);
  if (isHalfSpace(area))
    throw BadInput(std::string(option) + ": a half-space is no area; give a body");
  return solidOf(area, voxel, common);
}

ContactQuery readQuery(const ContactOptions& options) {
  checkTogether(options.common);
  if (std::holds_alternative<Rigid>(options.common.law))
    throw BadInput("--law rigid: has no force until a solver runs; use paper or foundation");
  if (isViscoelastic(options.common.law))
    throw BadInput("--law: its force depends on the past; use paper, or simulate");
  ContactQuery query;
  query.common = options.common;
  query.repeat = options.repeat;
  query.pose = readPose("--pose", options.pose);
  if (!options.velocity.empty()) query.motion = readVelocity("--velocity", options.velocity);
  query.motion.center = query.pose.position;  // the velocity is given at B's origin
  checkThresholds(options.common,
                  {options.a, options.b, options.common.paper.areaA, options.common.paper.areaB});
  std::tie(query.a, query.b) = bothOf(
      options.common.threads, [&] { return readBody(options.a, options.common); },
      [&] { return readBody(options.b, options.common); });
  if (isHalfSpace(query.a) && isHalfSpace(query.b))
    throw BadInput("halfspace: two half-spaces have no contact to find; make A or B a body");
  const double voxel = sharedVoxel(query);
  const PaperOptions& paper = options.common.paper;
  query.areaA = readArea("--area-a", paper.areaA, query.a, voxel, options.common);
  query.areaB = readArea("--area-b", paper.areaB, query.b, voxel, options.common);
  return query;
}

// The quantile of sorted times at `share`.
double quantile(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return 0;
  const auto last = static_cast<double>(sorted.size() - 1);
  return sorted[static_cast<std::size_t>(std::ceil(share * last))];
}

Json reportJson(const ContactReport& report, const CommonOptions& options) {
  Json json;
  json["method"] = nameOf(options.method);
  json["backend"] = nameOf(report.backend);
  json["force"] = asJson(report.onB.force);
  json["torque"] = asJson(report.onB.torque);
  json["contacts"] = Json::array();
  for (const ReportedContact& c : report.contacts)
    json["contacts"].push_back({{"position", asJson(c.position)},
                                {"normal", asJson(c.normal)},
                                {"depth", c.depth},
                                {"stiffness", c.stiffness},
                                {"damping", c.damping},
                                {"patch", c.patch},
                                {"confidence", c.confidence}});
  json["patches"] = report.patches;
  json["samples"] = report.samples;
  std::vector<double> times = report.microseconds;
  std::sort(times.begin(), times.end());
  json["microseconds"] = {{"median", quantile(times, 0.5)}, {"p99", quantile(times, 0.99)}};
  return json;
}

std::string counted(std::size_t count, const char* what, const char* plural) {
  return std::to_string(count) + (count == 1 ? what : plural);
}

void printContact(const Json& j) {
  std::cout << j["method"].get<std::string>() << ": "
            << counted(j["contacts"].size(), " contact", " contacts") << " in "
            << counted(j["patches"].get<std::size_t>(), " patch", " patches") << '\n'
            << "  force on B  " << vectorText(j["force"]) << " N\n"
            << "  torque on B " << vectorText(j["torque"]) << " N m, about the world's origin\n"
            << "  time        " << j["microseconds"]["median"].get<double>() << " us, 99 % within "
            << j["microseconds"]["p99"].get<double>() << " us\n";
  for (const Json& c : j["contacts"])
    std::cout << "  at " << vectorText(c["position"]) << "  normal " << vectorText(c["normal"])
              << "  depth " << c["depth"].get<double>() << "  k " << c["stiffness"].get<double>()
              << "  patch " << c["patch"] << '\n';
}

ContactReport contactOf(const ContactQuery& query, const std::optional<std::string>& picture) {
  if (!usesClouds(query.common.method)) {
    if (query.common.backend == Backend::OpenCl)
      reportCpuFallback("only --method cloud can use it");
    return bulletContact(query);
  }
  if (!picture) return cloudContact(query);
  ContactScene scene;
  ContactReport report = cloudContact(query, &scene);
  savePicture(contactPicture(scene), *picture);
  return report;
}

void run(const ContactOptions& options) {
  if (options.picture) {
    checkPicture(*options.picture);
    if (!usesClouds(options.common.method))
      throw BadInput("--picture: shows the method of clouds; use it with --method cloud or paper");
  }
  const ContactQuery query = readQuery(options);
  const Json json = reportJson(contactOf(query, options.picture), options.common);
  if (options.common.json)
    std::cout << jsonText(json) << '\n';
  else
    printContact(json);
}

}  // namespace

Law pairLaw(const CommonOptions& options) {
  const double damping = options.damping.value_or(0);
  if (std::holds_alternative<Foundation>(options.law))
    return Foundation{options.stiffness.value_or(kFoundationStiffness), damping};
  return KelvinVoigt{options.stiffness.value_or(kPaperStiffness), damping};
}

void addContactCommand(CLI::App& app) {
  auto options = std::make_shared<ContactOptions>();
  CLI::App& command = *app.add_subcommand(
      "contact",
      "find the contact of body B with body A: points, force and time.\n"
      "A is at the origin. Stiffness is 1e4 N/m (1e9 N/m^3 with foundation) if not given.");
  command
      .add_option("A", options->a,
                  "mesh file, point file, CT volume, .cloud file, primitive or halfspace")
      ->required();
  command.add_option("B", options->b, "as A")->required();
  command.add_option("--pose", options->pose, "of B: \"x y z\" or \"x y z qx qy qz qw\" [m]")
      ->required()
      ->type_name("POSE");
  command
      .add_option("--velocity", options->velocity,
                  "of B's origin: \"vx vy vz wx wy wz\" [m/s, rad/s]")
      ->type_name("VELOCITY");
  command
      .add_option_function<std::string>(
          "--repeat",
          [options](const std::string& text) {
            options->repeat = readCount("--repeat", text, 1, kMostRepeats);
          },
          "number of timed calls (default 100)")
      ->type_name("N");
  command
      .add_option_function<std::string>(
          "--picture", [options](const std::string& text) { options->picture = text; },
          "file for a picture of a cut through the contact")
      ->type_name("FILE.png|FILE.svg");
  command
      .add_option("--area-a", options->common.paper.areaA,
                  "A's collision detection area D in A's frame, a body; all of A if not given")
      ->type_name("BODY");
  command
      .add_option("--area-b", options->common.paper.areaB,
                  "B's in B's frame; all of B if not given")
      ->type_name("BODY");
  addBodyOptions(command, options->common);
  addLawOptions(command, options->common);
  addTissueOptions(command, options->common, "none if not given");
  addMethodOption(command, options->common);
  addSamplesOption(command, options->common);
  addPaperOptions(command, options->common);
  addBackendOption(command, options->common);
  addCacheOption(command, options->common);
  addRunOptions(command, options->common);
  addExamples(
      command,
      {R"(cloudcontact contact bolt.stl nut.stl --unit mm --voxel 0.00025 --pose "0 0 0.0078")",
       R"(cloudcontact contact halfspace sphere:0.01 --pose "0 0 0.0098" --stiffness 5000 --json)"});
  command.callback([options] { run(*options); });
}

}  // namespace cloudcontact::program
