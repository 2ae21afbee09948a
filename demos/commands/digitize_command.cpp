// `cloudcontact digitize BODY [-o FILE.cloud] [--picture FILE]`: a body as voxels, with its mass
// and the time and memory it takes.
#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/voxels/cloud_file.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include "commands/command_tree.h"
#include "commands/commands.h"
#include "draw/cloud_picture.h"
#include "draw/picture_file.h"
#include "io/json.h"
#include "io/output_file.h"
#include "scene/body.h"

namespace cloudcontact::program {

namespace {

constexpr double kWater = 1000;  // default density [kg/m^3]

struct DigitizeOptions {
  CommonOptions common;
  std::string body;
  std::string output;                  // a .cloud file; empty: none
  std::optional<std::string> picture;  // a file
  double density = kWater;
};

struct Digitized {
  Cloud cloud;
  bool closed = true;
  Backend backend = Backend::Cpu;
  std::shared_ptr<const SurfaceField> field;
  double cloudMilliseconds = 0, fieldMilliseconds = 0;
};

double millisecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

Digitized digitizeWhole(const Body& body, const DigitizeOptions& options) {
  const double voxel = options.common.voxel.value_or(defaultVoxel(body));
  if (options.common.backend == Backend::OpenCl && !body.mesh && !body.shape)
    reportCpuFallback(options.body + " is not a mesh");
  Digitized result;
  const auto start = std::chrono::steady_clock::now();
  DigitizedBody digitized = digitizeBody(body, voxel, options.common);
  result.cloud = std::move(digitized.cloud);
  result.closed = digitized.closed;
  result.backend = digitized.backend;
  result.cloudMilliseconds = millisecondsSince(start);
  const auto middle = std::chrono::steady_clock::now();
  result.field = buildField(result.cloud, body.name, options.common);
  result.fieldMilliseconds = millisecondsSince(middle);
  return result;
}

// Name and volume of each material, from the sum of its coverage.
Json materialsJson(const Cloud& cloud) {
  std::vector<std::uint64_t> sums(cloud.materials().size(), 0);
  const Eigen::Vector3i size = cloud.size();
  for (int z = 0; z < size.z(); ++z)
    for (int y = 0; y < size.y(); ++y)
      for (int x = 0; x < size.x(); ++x)
        if (const int c = cloud.coverage(x, y, z))
          sums[cloud.material(x, y, z)] += std::uint64_t(c);
  Json json = Json::array();
  const double h = cloud.voxelSize();
  for (std::size_t m = 0; m < sums.size(); ++m)
    json.push_back({{"name", cloud.materials()[m]}, {"volume", double(sums[m]) / 255 * h * h * h}});
  return json;
}

Json resultJson(const Digitized& d, double density) {
  const VoxelCounts counts = d.cloud.counts();
  const MassProperties mass = d.cloud.massProperties();
  Json json;
  json["backend"] = nameOf(d.backend);
  json["voxelSize"] = d.cloud.voxelSize();
  json["voxels"] = counts.inside + counts.interface;
  json["bandVoxels"] = d.field->bandVoxels();
  json["volume"] = mass.volume;
  json["density"] = density;
  json["mass"] = density * mass.volume;
  json["centerOfMass"] = asJson(mass.centerOfMass);
  json["inertia"] = asJson(Eigen::Matrix3d(density * mass.inertia));
  json["bytes"] = d.cloud.bytes() + d.field->bytes();
  if (!d.cloud.materials().empty()) json["materials"] = materialsJson(d.cloud);
  json["cloudBytes"] = d.cloud.bytes();
  json["fieldBytes"] = d.field->bytes();
  json["closed"] = d.closed;
  json["milliseconds"] = d.cloudMilliseconds + d.fieldMilliseconds;
  json["cloudMilliseconds"] = d.cloudMilliseconds;
  json["fieldMilliseconds"] = d.fieldMilliseconds;
  return json;
}

void printCloud(const std::string& name, const Json& j) {
  const auto n = [&](const char* field) { return j[field].get<double>(); };
  std::cout << name << " in voxels of " << n("voxelSize") << " m\n"
            << "  voxels         " << j["voxels"] << ", near the surface " << j["bandVoxels"]
            << '\n'
            << "  volume         " << n("volume") << " m^3\n"
            << "  mass           " << n("mass") << " kg at " << n("density") << " kg/m^3\n"
            << "  center of mass " << vectorText(j["centerOfMass"]) << " m\n"
            << "  memory         " << n("bytes") / 1e6 << " MB (voxels " << n("cloudBytes") / 1e6
            << ", field " << n("fieldBytes") / 1e6 << ")\n"
            << "  time           " << n("milliseconds") << " ms (voxels " << n("cloudMilliseconds")
            << ", field " << n("fieldMilliseconds") << ")\n";
  if (!j["closed"].get<bool>())
    std::cout << "  the mesh is not closed: where one axis was ambiguous, others decided\n";
}

void run(const DigitizeOptions& options) {
  if (!options.output.empty()) checkOutput("-o", options.output, {".cloud"});
  if (options.picture) checkPicture(*options.picture);
  checkThresholds(options.common, {options.body});
  const Body body = readBody(options.body, options.common);
  const Digitized digitized = digitizeWhole(body, options);
  if (!options.output.empty()) {
    try {
      saveCloud(digitized.cloud, options.output);
    } catch (const std::runtime_error& error) {
      throw WorkFailed(std::string("-o: ") + error.what());
    }
  }
  if (options.picture) savePicture(cloudPicture(options.body, digitized.field), *options.picture);
  const Json json = resultJson(digitized, options.density);
  if (options.common.json)
    std::cout << jsonText(json) << '\n';
  else
    printCloud(options.body, json);
}

}  // namespace

void addDigitizeCommand(CLI::App& app) {
  auto options = std::make_shared<DigitizeOptions>();
  CLI::App& command = *app.add_subcommand("digitize", "turn a body into voxels and measure it");
  command
      .add_option("BODY", options->body,
                  "mesh file, point file, CT volume, .cloud file or primitive")
      ->required();
  command.add_option("-o,--output", options->output, "file for the cloud")->type_name("FILE.cloud");
  command
      .add_option_function<std::string>(
          "--picture", [options](const std::string& text) { options->picture = text; },
          "file for a picture of the cloud: slices and a view")
      ->type_name("FILE.png|FILE.svg");
  addPositive(command, "--density", "density for mass and inertia [kg/m^3] (default 1000)", "RHO",
              [options](double v) { options->density = v; });
  addBodyOptions(command, options->common);
  addBackendOption(command, options->common);
  addRunOptions(command, options->common);
  addExamples(command,
              {"cloudcontact digitize nut.stl --unit mm --voxel 0.00025 -o nut.cloud",
               "cloudcontact digitize sphere:0.01 --voxel 0.001 --picture ball.png --json"});
  command.callback([options] { run(*options); });
}

}  // namespace cloudcontact::program
