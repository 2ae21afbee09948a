// The strict readers of option values.
#include "io/options.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iostream>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include "io/errors.h"

namespace cloudcontact::program {

namespace {

using Names = std::vector<std::pair<std::string_view, int>>;

const Names& methodNames() {
  static const Names names = {{"cloud", int(Method::Cloud)}, {"paper", int(Method::Paper)},
                              {"gjk", int(Method::Gjk)},     {"gimpact", int(Method::Gimpact)},
                              {"hacd", int(Method::Hacd)},   {"primitive", int(Method::Primitive)},
                              {"sdf", int(Method::Sdf)}};
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

// Of single numbers: what Bullet's float can hold, and multiply.
constexpr double kMost = 1e30;

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

}  // namespace

Law readLaw(const std::string& text) {
  if (const auto law = readViscoelastic(text)) return *law;
  const Law plain[] = {KelvinVoigt{}, Foundation{}, Rigid{}};
  return plain[readName("--law", text, lawNames())];
}

Method readMethod(const std::string& text) {
  return Method(readName("--method", text, methodNames()));
}

Backend readBackend(const std::string& text) {
  return Backend(readName("--backend", text, backendNames()));
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

bool isViscoelastic(const Law& law) {
  return !std::holds_alternative<KelvinVoigt>(law) && !std::holds_alternative<Foundation>(law) &&
         !std::holds_alternative<Rigid>(law);
}

bool usesClouds(Method method) {
  return method == Method::Cloud || method == Method::Paper;
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

namespace {

void checkPaper(const CommonOptions& o) {
  const std::pair<const char*, bool> given[] = {
      {"--window", o.paper.window.has_value()},
      {"--representative", o.paper.representative.has_value()},
      {"--hardness", o.paper.hardness},
      {"--membership", o.paper.membership != Membership::Shared},
      {"--area-a", !o.paper.areaA.empty()},
      {"--area-b", !o.paper.areaB.empty()}};
  for (const auto& [name, isGiven] : given)
    if (isGiven && o.method != Method::Paper)
      throw BadInput(std::string(name) + ": belongs to base vectors; give --method paper with it");
  if (o.paper.hardness && !o.tissues.hasTable())
    throw BadInput("--hardness: h is that of tissues; give --tissues with it");
}

void checkTissues(const CommonOptions& o) {
  if (!o.tissues.given()) return;
  if (!o.tissues.hasTable())
    throw BadInput("--tissue: needs a table of tissues; give --tissues dental or FILE.json");
  if (!usesClouds(o.method))
    throw BadInput("--tissues: Bullet's own shapes have no voxels; use --method cloud or paper");
  if (o.stiffness || o.damping)
    throw BadInput(std::string(o.stiffness ? "--stiffness" : "--damping") +
                   ": with --tissues k and c are those of the tissues; leave one of the two out");
  if (isViscoelastic(o.law) || std::holds_alternative<Rigid>(o.law))
    throw BadInput("--law: tissues have k and c alone; use paper or foundation with --tissues");
}

}  // namespace

void checkTogether(const CommonOptions& options) {
  if (options.samples && !usesClouds(options.method))
    throw BadInput("--samples: Bullet's own methods have none; use --method cloud or paper");
  checkPaper(options);
  checkTissues(options);
}

double readNumber(std::string_view option, const std::string& text) {
  const std::optional<double> value = number(text);
  if (!value) refuse(option, text, "a finite number");
  return *value;
}

double readPositive(std::string_view option, const std::string& text) {
  const std::optional<double> value = number(text);
  if (!value || !(*value > 0) || *value > kMost)
    refuse(option, text, "a finite number greater than 0, up to 1e30");
  return *value;
}

double readNotNegative(std::string_view option, const std::string& text) {
  const std::optional<double> value = number(text);
  if (!value || *value < 0 || *value > kMost)
    refuse(option, text, "a finite number of 0 or more, up to 1e30");
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

Vec3 readVector(std::string_view option, const std::string& text) {
  const std::vector<double> v = numbers(text);
  if (v.size() != 3) refuse(option, text, "three numbers \"x y z\", none beyond 1e9");
  return {v[0], v[1], v[2]};
}

std::pair<std::string, std::string> readTissueName(const std::string& option,
                                                   const std::string& text) {
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
    refuse(option, text, "PART=TISSUE");
  return {text.substr(0, equals), text.substr(equals + 1)};
}

CtRange readThreshold(const std::string& option, const std::string& text) {
  const std::size_t equals = text.rfind('=');
  if (equals == 0) refuse(option, text, "T or NAME=T");
  if (equals == std::string::npos) return {readNumber(option, text), ""};
  return {readNumber(option, text.substr(equals + 1)), text.substr(0, equals)};
}

void addThreshold(const std::string& option, CtRange threshold, std::vector<CtRange>& to) {
  const auto at = std::find_if(to.begin(), to.end(),
                               [&](const CtRange& r) { return r.from >= threshold.from; });
  if (at != to.end() && at->from == threshold.from)
    throw BadInput(option + ": two materials begin at one value; leave one out");
  to.insert(at, std::move(threshold));
  if (to.size() == 1) return;
  std::set<std::string> names;
  for (const CtRange& range : to) {
    if (range.name.empty())
      throw BadInput(option + ": where there are several, each has a name; give NAME=T");
    if (!names.insert(range.name).second)
      throw BadInput(option + ": " + range.name + " begins at two values; leave one out");
  }
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
