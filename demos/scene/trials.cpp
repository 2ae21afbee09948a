// Trials look the same contacts up with different voxels: poses and instants do not depend on them.
#include "scene/trials.h"

#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/contact/depth_error.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <utility>

#include "io/errors.h"
#include "scene/scene_clouds.h"
#include "scene/tissue_file.h"
#include "scene/world.h"

namespace cloudcontact::program {

namespace {

constexpr double kCoarsest = 16;      // of the default voxel
constexpr std::size_t kBuilding = 8;  // building takes this many times the memory of the result
// A hit costs as much as this many lookups (docs/measurements.md, "One pair").
constexpr double kPerHit = 3.3;
constexpr int kRepeat = 25;
constexpr int kInstants = 4;

using Clock = std::chrono::steady_clock;

TuneLimits limitsFor(double voxel, bool fixed) {
  return {fixed ? voxel : kCoarsest * voxel, fixed, freeMemory() / kBuilding};
}

struct PairPlace {
  Body a, b;
  std::vector<Pose> poses;  // of B
  Law law;
  CommonOptions options;
  // The fields of the latest voxel; null for a half-space.
  double voxel = 0;
  std::shared_ptr<const SurfaceField> fields[2];
  TissueTable tissues[2] = {};

  void build(double size) {
    if (size == voxel) return;
    voxel = size;
    for (const bool second : {false, true}) {
      const Body& body = second ? b : a;
      fields[second] = nullptr;
      if (isHalfSpace(body)) continue;
      fields[second] = buildField(digitizeBody(body, size, options).cloud, body.name, options);
    }
    BodyTissues table(options.tissues);
    for (const bool second : {false, true})
      if (fields[second])
        tissues[second] = table.of((second ? b : a).name, fields[second]->cloud().materials());
    table.check();
  }
  ContactBody at(bool second, const Pose& pose) const {
    ContactBody body;
    body.field = fields[second].get();
    const Body& from = second ? b : a;
    if (!body.field) body.shape = &*from.shape;
    if (!tissues[second].empty()) body.tissues = &tissues[second];
    body.pose = pose;
    return body;
  }
};

// The median time of a query at one pose, which moves by 1e-3 voxel between repetitions.
double microsecondsOf(const PairPlace& place, const Pose& pose, const ContactSettings& settings) {
  ContactFinder finder;
  std::vector<double> times;
  for (int k = -1; k < kRepeat; ++k) {
    Pose moved = pose;
    moved.position += 1e-3 * place.voxel * Vec3(k % 3 - 1, k % 5 - 2, k % 7 - 3);
    const ContactBody a = place.at(false, {}), b = place.at(true, moved);
    const auto start = Clock::now();
    finder.find(a, b, settings);
    const std::chrono::duration<double, std::micro> time = Clock::now() - start;
    if (k >= 0) times.push_back(time.count());
  }
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

Trial attemptPair(PairPlace& place, const TuneSetting& setting) {
  place.build(setting.voxel);
  Trial trial;
  trial.setting = setting;
  for (const auto& field : place.fields)
    if (field) trial.bytes += field->bytes() + field->cloud().bytes();
  ContactSettings settings;
  settings.law = place.law;
  settings.samples = setting.samples;
  settings.margin = setting.voxel;
  trial.level = 2;
  for (const Pose& pose : place.poses) {
    const ContactBody a = place.at(false, {}), b = place.at(true, pose);
    ContactFinder finder;
    const ContactResult& found = finder.find(a, b, settings);
    const bool touches = !found.patches.empty();
    trial.depths.push_back(touches ? depthOf(found) : Trial::kApart);
    trial.stated.push_back(depthError(a, b, found));
    trial.lookups += double(finder.sampleLookups()) + kPerHit * double(found.samples);
    trial.level = std::min(trial.level, found.level);
  }
  trial.microseconds = microsecondsOf(place, place.poses.front(), settings);
  return trial;
}

// A scene at one instant: the bodies stand where they were then.
std::vector<SceneDescription> instantsOf(const SceneDescription& scene, double seconds,
                                         const WorldSettings& settings) {
  World world(scene, settings);
  std::vector<SceneDescription> instants;
  const int steps = std::max(1, static_cast<int>(seconds / scene.step));
  for (int k = 1; k <= steps; ++k) {
    world.step(scene.step);
    if (k * kInstants / steps == (k - 1) * kInstants / steps) continue;
    SceneDescription now = scene;
    now.joints.clear();
    for (std::size_t i = 0; i < now.bodies.size(); ++i) now.bodies[i].pose = world.pose(i);
    instants.push_back(std::move(now));
  }
  return instants;
}

struct ScenePlaces {
  std::vector<SceneDescription> instants;
  WorldSettings settings;
  // One for each pair that has met at an instant, in the order in which they were seen.
  std::map<std::pair<std::size_t, std::pair<std::size_t, std::size_t>>, std::size_t> places;
};

std::size_t bytesOf(const SceneDescription& scene, const WorldSettings& settings) {
  SceneClouds clouds(settings.common, settings.voxel, settings.store, traitsOf(scene));
  std::map<const SurfaceField*, std::size_t> sizes;
  for (const SceneBody& body : scene.bodies)
    for (const SceneCollision& collision : body.collisions) {
      if (clouds.meetsAsShape(collision, body)) continue;
      const auto field = clouds.field(collision.geometry, collision.pose, body.name).field;
      sizes[field.get()] = field->bytes() + field->cloud().bytes();
    }
  std::size_t sum = 0;
  for (const auto& [field, bytes] : sizes) sum += bytes;
  return sum;
}

Trial attemptScene(ScenePlaces& scene, const TuneSetting& setting) {
  Trial trial;
  trial.setting = setting;
  trial.level = 2;
  WorldSettings settings = scene.settings;
  settings.voxel = setting.voxel;
  settings.common.samples = static_cast<int>(setting.samples);
  settings.store = std::make_shared<ShapeStore>();
  const auto placeOf = [&](std::size_t instant, const PairUse& pair) {
    const auto key = std::make_pair(instant, std::minmax(pair.a, pair.b));
    return scene.places.try_emplace(key, scene.places.size()).first->second;
  };
  for (std::size_t k = 0; k < scene.instants.size(); ++k) {
    World world(scene.instants[k], settings);
    world.findContacts();
    for (const PairUse& pair : world.pairs()) {
      const std::size_t place = placeOf(k, pair);
      trial.depths.resize(std::max(trial.depths.size(), place + 1), Trial::kApart);
      trial.stated.resize(trial.depths.size(), 0);
      if (pair.report.expectedError > 0) trial.depths[place] = pair.report.depth;
      trial.stated[place] = pair.report.expectedError;
      trial.lookups += double(pair.report.work.samples);
      trial.microseconds += 1e6 * pair.report.seconds / double(scene.instants.size());
      if (pair.report.searched > 0) trial.level = std::min(trial.level, pair.report.level);
    }
  }
  trial.bytes = bytesOf(scene.instants.front(), settings);
  return trial;
}

}  // namespace

Trials pairTrials(const Body& a, const Body& b, const Pose& pose, const Law& law,
                  const CommonOptions& options) {
  auto place = std::make_shared<PairPlace>(PairPlace{a, b, {pose}, law, options, 0, {}});
  place->options.backend = Backend::Cpu;
  for (int k = 0; k < 8; ++k) {
    Pose moved = pose;
    moved.position +=
        options.tolerance / 2 * Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1).normalized();
    place->poses.push_back(moved);
  }
  double voxel = 0;
  for (const Body* body : {&a, &b}) {
    if (isHalfSpace(*body)) continue;
    const double own = defaultVoxel(*body);
    if (body->cloud && (voxel == 0 || !a.cloud)) voxel = own;
    if (!a.cloud && !b.cloud) voxel = voxel > 0 ? std::min(voxel, own) : own;
  }
  return {limitsFor(voxel, a.cloud || b.cloud),
          [place](const TuneSetting& setting) { return attemptPair(*place, setting); }};
}

Trials sceneTrials(const SceneDescription& scene, double seconds, const CommonOptions& options) {
  auto places = std::make_shared<ScenePlaces>();
  WorldSettings& settings = places->settings;
  settings.common = options;
  settings.common.tolerance = 0;
  settings.common.exact = true;
  settings.common.explain = true;
  settings.voxel = defaultVoxel(scene, options);
  settings.store = std::make_shared<ShapeStore>();
  places->instants = instantsOf(scene, seconds, settings);
  settings.common.friction = settings.common.friction.value_or(0);  // said once who has none
  settings.store = nullptr;
  return {limitsFor(settings.voxel, false),
          [places](const TuneSetting& setting) { return attemptScene(*places, setting); }};
}

}  // namespace cloudcontact::program
