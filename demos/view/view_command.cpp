// Reads commands (view_command.h). Pages are not trusted.
#include "view/view_command.h"

#include <cmath>

#include "io/json.h"

namespace cloudcontact::program {
namespace {

constexpr double kLeastSpeed = 1e-6, kMostSpeed = 1000;  // times real time
constexpr double kFarthest = 1e6;                        // [m]

std::optional<double> numberIn(const Json& json, const char* name, double least, double most) {
  const auto found = json.find(name);
  if (found == json.end() || !found->is_number()) return {};
  const double value = found->get<double>();
  if (!(value >= least && value <= most)) return {};
  return value;
}

std::optional<std::size_t> bodyIn(const Json& json) {
  const auto found = json.find("body");
  if (found == json.end() || !found->is_number_unsigned()) return {};
  return found->get<std::size_t>();
}

std::optional<Vec3> placeIn(const Json& json, const char* name) {
  const auto found = json.find(name);
  if (found == json.end() || !found->is_array() || found->size() != 3) return {};
  Vec3 place;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(*found)[k].is_number()) return {};
    place[static_cast<Eigen::Index>(k)] = (*found)[k].get<double>();
  }
  if (!(place.cwiseAbs().maxCoeff() <= kFarthest)) return {};
  return place;
}

std::optional<ViewCommand> speedOf(const Json& json) {
  const auto times = numberIn(json, "times", 0, kMostSpeed);
  if (!times || (*times > 0 && *times < kLeastSpeed)) return {};
  return SetSpeed{*times};
}

std::optional<ViewCommand> pullOf(const Json& json) {
  const auto body = bodyIn(json);
  const auto at = placeIn(json, "at"), to = placeIn(json, "to");
  if (!body || !at || !to) return {};
  return PullBody{*body, *at, *to};
}

std::optional<ViewCommand> cutOf(const Json& json) {
  const auto body = bodyIn(json);
  const auto at = placeIn(json, "at");
  const auto radius = numberIn(json, "radius", 1e-9, kFarthest);
  if (!body || !at || !radius) return {};
  return CutBall{*body, *at, *radius};
}

}  // namespace

std::optional<ViewCommand> readCommand(const std::string& text) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object() || !json.contains("do") || !json["do"].is_string()) return {};
  const std::string what = json["do"];
  if (what == "run") return RunOn{};
  if (what == "pause") return Pause{};
  if (what == "step") return StepOnce{};
  if (what == "speed") return speedOf(json);
  if (what == "pull") return pullOf(json);
  if (what == "release") return Release{};
  if (what == "cut") return cutOf(json);
  return {};
}

bool isPull(const std::string& text) {
  const auto command = readCommand(text);
  return command && std::holds_alternative<PullBody>(*command);
}

}  // namespace cloudcontact::program
