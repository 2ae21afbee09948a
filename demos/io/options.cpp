// The common options and the strict readers.
#include "io/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iostream>
#include <sstream>
#include <utility>
#include <vector>

#include "io/errors.h"

namespace cloudcontact::program {

namespace {

using Names = std::vector<std::pair<std::string_view, int>>;

const Names& methodNames() {
  static const Names names = {{"cloud", int(Method::Cloud)},         {"gjk", int(Method::Gjk)},
                              {"gimpact", int(Method::Gimpact)},     {"hacd", int(Method::Hacd)},
                              {"primitive", int(Method::Primitive)}, {"sdf", int(Method::Sdf)}};
  return names;
}

const Names& backendNames() {
  static const Names names = {{"cpu", int(Backend::Cpu)}, {"opencl", int(Backend::OpenCl)}};
  return names;
}

const Names& lawNames() {  // by the place in readLaw()
  static const Names names = {{"paper", 0}, {"foundation", 1}, {"rigid", 2}};
  return names;
}

std::string_view nameIn(const Names& names, int value) {
  for (const auto& [name, known] : names)
    if (known == value) return name;
  return "?";
}

int readName(std::string_view option, const std::string& text, const Names& names) {
  std::string known;
  for (const auto& [name, value] : names) {
    if (name == text) return value;
    known += (known.empty() ? "" : ", ") + std::string(name);
  }
  throw BadInput(std::string(option) + ": '" + text + "' is not known; use one of " + known);
}

[[noreturn]] void refuse(std::string_view option, const std::string& text, const char* wanted) {
  throw BadInput(std::string(option) + ": '" + text + "' is not usable; give " + wanted);
}

// `text` as a finite number; empty if any part of it is something else.
std::optional<double> number(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

// Largest magnitude. Bullet may run in single precision, where the square of larger numbers loses
// meaning.
constexpr double kGreatest = 1e9;

// Numbers separated by blanks; empty if one is invalid or above kGreatest.
std::vector<double> numbers(const std::string& text) {
  std::vector<double> values;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const std::optional<double> value = number(word);
    if (!value || std::abs(*value) > kGreatest) return {};
    values.push_back(*value);
  }
  return values;
}

double readUnit(const std::string& text) {
  constexpr std::array<std::pair<std::string_view, double>, 4> units = {
      {{"mm", 0.001}, {"cm", 0.01}, {"in", 0.0254}, {"m", 1}}};
  for (const auto& [name, meters] : units)
    if (name == text) return meters;
  // Downloaded models come in any unit, so a number is valid too.
  if (const std::optional<double> meters = number(text);
      meters && *meters > 0 && *meters <= kGreatest)
    return *meters;
  throw BadInput("--unit: '" + text +
                 "' is not known; use one of mm, cm, in, m, or a unit's length in meters");
}

// Adds an option whose text goes through `reader`.
template <class Reader>
void add(CLI::App& command, const std::string& name, const std::string& help, const char* type,
         Reader reader) {
  command
      .add_option_function<std::string>(
          name, [reader](const std::string& text) { reader(text); }, help)
      ->type_name(type);
}

// Reads "maxwell:K,C" or "solid:K,K1,C1"; empty for a plain name.
std::optional<Law> readViscoelastic(const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) return {};
  const std::string name = text.substr(0, colon);
  std::string values = text.substr(colon + 1);
  std::replace(values.begin(), values.end(), ',', ' ');
  const std::vector<double> v = numbers(values);
  if (name == "maxwell" && v.size() == 2 && v[0] > 0 && v[1] > 0) return Maxwell{v[0], v[1]};
  if (name == "solid" && v.size() == 3 && v[0] > 0 && v[1] > 0 && v[2] > 0)
    return StandardLinearSolid{v[0], v[1], v[2]};
  refuse("--law", text, "maxwell:K,C or solid:K,K1,C1, positive, in N/m and N s/m");
}

void readLaw(const std::string& text, CommonOptions& o) {
  if (const auto law = readViscoelastic(text)) {
    o.law = *law;
    return;
  }
  const Law plain[] = {KelvinVoigt{}, Foundation{}, Rigid{}};
  o.law = plain[readName("--law", text, lawNames())];
}

void addLawOptions(CLI::App& command, CommonOptions& o) {
  add(command, "--law",
      "contact law: paper (one spring a pair), foundation (stiffness per area); for simulate also "
      "maxwell:K,C (spring and dashpot in series), solid:K,K1,C1 (a spring beside such a pair)",
      "LAW", [&o](const std::string& t) { readLaw(t, o); });
  add(command, "--stiffness", "the pair's k [N/m]; per area [N/m^3] with foundation", "K",
      [&o](const std::string& t) { o.stiffness = readPositive("--stiffness", t); });
  add(command, "--damping", "the pair's c [N s/m]; per area [N s/m^3] with foundation", "C",
      [&o](const std::string& t) { o.damping = readNotNegative("--damping", t); });
  add(command, "--friction", "the pair's friction coefficient", "MU",
      [&o](const std::string& t) { o.friction = readNotNegative("--friction", t); });
  add(command, "--material", "a material's name or file (not supported yet)", "NAME|FILE",
      [](const std::string& t) {
        throw BadInput("--material: '" + t +
                       "' cannot be looked up, materials tables are not supported yet; give "
                       "--stiffness and --damping instead");
      });
}

}  // namespace

bool isViscoelastic(const Law& law) {
  return !std::holds_alternative<KelvinVoigt>(law) && !std::holds_alternative<Foundation>(law) &&
         !std::holds_alternative<Rigid>(law);
}

std::string_view nameOf(Method method) {
  return nameIn(methodNames(), int(method));
}
std::string_view nameOf(Backend backend) {
  return nameIn(backendNames(), int(backend));
}

void reportCpuFallback(const std::string& why) {
  std::cerr << "cloudcontact: --backend opencl: " << why << "; using cpu\n";
}

void addCommonOptions(CLI::App& command, CommonOptions& o, Devices devices) {
  add(command, "--voxel", "edge of a voxel [m]; a hundredth of the body's diagonal if not given",
      "H", [&o](const std::string& t) { o.voxel = readPositive("--voxel", t); });
  add(command, "--unit", "unit of mesh files: mm, cm, in, m, or its length in meters (default m)",
      "UNIT", [&o](const std::string& t) { o.metersPerUnit = readUnit(t); });
  add(command, "--shell", "thickness given to a sheet [m]; three voxels if not given", "THICKNESS",
      [&o](const std::string& t) { o.shell = readPositive("--shell", t); });
  addLawOptions(command, o);
  add(command, "--method", "cloud, or Bullet's gjk, gimpact, hacd, primitive, sdf", "METHOD",
      [&o](const std::string& t) { o.method = Method(readName("--method", t, methodNames())); });
  const bool none = devices == Devices::None;
  add(command, "--backend", none ? "cpu" : "cpu, or opencl for a GPU", "BACKEND",
      [&o, none, name = command.get_name()](const std::string& t) {
        o.backend = Backend(readName("--backend", t, backendNames()));
        if (o.backend != Backend::OpenCl || !none) return;
        reportCpuFallback(name + " cannot use a device");
        o.backend = Backend::Cpu;
      });
  add(command, "--threads", "threads to use; 0 means all cores (default)", "N",
      [&o](const std::string& t) { o.threads = readCount("--threads", t, 0, 1024); });
  command.add_flag("--json", o.json, "print the result as JSON");
}

double readNumber(std::string_view option, const std::string& text) {
  const std::optional<double> value = number(text);
  if (!value) refuse(option, text, "a finite number");
  return *value;
}

double readPositive(std::string_view option, const std::string& text) {
  const std::optional<double> value = number(text);
  if (!value || !(*value > 0)) refuse(option, text, "a finite number greater than 0");
  return *value;
}

double readNotNegative(std::string_view option, const std::string& text) {
  const std::optional<double> value = number(text);
  if (!value || *value < 0) refuse(option, text, "a finite number of 0 or more");
  return *value;
}

int readCount(std::string_view option, const std::string& text, int least, int most) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  if (!whole || value < least || value > most) {
    const std::string wanted =
        "a whole number from " + std::to_string(least) + " to " + std::to_string(most);
    refuse(option, text, wanted.c_str());
  }
  return value;
}

Pose readPose(std::string_view option, const std::string& text) {
  const std::vector<double> v = numbers(text);
  if (v.size() != 3 && v.size() != 7)
    refuse(option, text, "\"x y z\" or \"x y z qx qy qz qw\", in meters, none beyond 1e9");
  Pose pose;
  pose.position = Vec3(v[0], v[1], v[2]);
  if (v.size() == 7) {
    const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
    // A length far from 1 is a typing error, not rounding.
    if (std::abs(q.norm() - 1) > 0.01) refuse(option, text, "a quaternion qx qy qz qw of length 1");
    pose.orientation = q.normalized();
  }
  return pose;
}

Motion readVelocity(std::string_view option, const std::string& text) {
  const std::vector<double> v = numbers(text);
  if (v.size() != 6)
    refuse(option, text, "\"vx vy vz wx wy wz\", in m/s and rad/s, none beyond 1e9");
  Motion motion;
  motion.linear = Vec3(v[0], v[1], v[2]);
  motion.angular = Vec3(v[3], v[4], v[5]);
  return motion;
}

}  // namespace cloudcontact::program
