// What a world is made with (world_setup.h).
#include "scene/world_setup.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <variant>

#include "io/errors.h"

namespace cloudcontact::program {
namespace {

constexpr double kBears = 100;  // for NewtonSolver

SurfaceSettings surfacesOf(const SceneDescription& scene, const CommonOptions& options) {
  SurfaceSettings settings;
  settings.friction = options.friction;
  if (options.stiffness)
    settings.pair = KelvinVoigt{*options.stiffness, options.damping.value_or(0)};
  settings.springsForBullet =
      !usesClouds(options.method) && !std::holds_alternative<Rigid>(options.law);
  for (const auto& body : scene.bodies) settings.bodies.push_back(surfaceOf(body));
  return settings;
}

bool hasTool(const SceneBody& body) {
  return std::any_of(body.collisions.begin(), body.collisions.end(),
                     [](const SceneCollision& c) { return c.cutter.has_value(); });
}

// --law with --stiffness and --damping; empty: the bodies decide.
std::optional<Law> pairLaw(const CommonOptions& options) {
  const double k = options.stiffness.value_or(0), c = options.damping.value_or(0);
  if (std::holds_alternative<Foundation>(options.law)) return Foundation{k, c};
  if (!std::holds_alternative<KelvinVoigt>(options.law)) return options.law;
  if (!options.stiffness) return {};
  return KelvinVoigt{k, c};
}

}  // namespace

Surface surfaceOf(const SceneBody& body) {
  Surface surface{body.friction, {}};
  // Damping alone is no spring; such a body is rigid.
  if (body.stiffness) surface.material = KelvinVoigt{*body.stiffness, body.damping.value_or(0)};
  return surface;
}

void checkOptions(const WorldSettings& settings) {
  const auto& o = settings.common;
  checkTogether(o);
  if (o.method == Method::Sdf)
    throw BadInput(
        "--method sdf: Bullet's signed distance fields do not move; use cloud, gjk, gimpact, hacd "
        "or primitive");
  if (o.damping && !o.stiffness)
    throw BadInput("--damping: needs --stiffness beside it, a pair has both or neither");
  if (isViscoelastic(o.law) && (o.stiffness || o.damping))
    throw BadInput("--law: this law has its own stiffness; leave --stiffness and --damping out");
  if (isViscoelastic(o.law) && !usesClouds(o.method))
    throw BadInput("--law: Bullet's own contacts follow Kelvin-Voigt only; use --method cloud");
  if (!usesClouds(o.method) && std::holds_alternative<Foundation>(o.law))
    throw BadInput("--law foundation: Bullet's own contacts have no area; use --method cloud");
}

std::vector<ModelFilter::Body> modelsOf(const SceneDescription& scene) {
  std::vector<ModelFilter::Body> models;
  for (const auto& body : scene.bodies)
    models.push_back({body.model, body.selfCollide, body.isFree(), hasTool(body),
                      !body.collisions.empty() && body.collisions.front().isCuttable});
  return models;
}

SceneDispatcher makeDispatcher(btCollisionConfiguration* configuration,
                               const SceneDescription& scene, const CommonOptions& options) {
  CloudDispatcherSettings clouds{.threads = options.threads, .backend = options.backend};
  if (!usesClouds(options.method)) {
    clouds = {.threads = 1};
    if (options.backend == Backend::OpenCl)
      reportCpuFallback("the method '" + std::string(nameOf(options.method)) + "' has no kernels");
  }
  try {
    return {configuration, surfacesOf(scene, options), clouds};
  } catch (const std::runtime_error& why) {
    if (clouds.backend == Backend::Cpu) throw;
    reportCpuFallback(why.what());
  }
  clouds.backend = Backend::Cpu;
  return {configuration, surfacesOf(scene, options), clouds};
}

std::unique_ptr<CloudContact> makeCloudContact(const CommonOptions& options) {
  CloudContactSettings settings;
  settings.law = pairLaw(options);
  settings.bears = kBears;
  if (options.samples) settings.samples = static_cast<std::size_t>(*options.samples);
  if (options.reuse) settings.reuseMotion = *options.reuse;
  settings.fidelity.budget = options.budget;
  settings.keepReports = options.explain;
  return std::make_unique<CloudContact>(settings);
}

}  // namespace cloudcontact::program
