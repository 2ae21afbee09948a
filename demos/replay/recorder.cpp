// Poses at every step, thinned as they come; contacts and figures at no more instants than a screen
// shows.
#include "replay/recorder.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace cloudcontact::program {
namespace {

constexpr double kTolerance = 3e-5;    // of the scene's size: 0.03 px at 1000 px
constexpr double kFramesASecond = 60;  // what a screen shows at full speed
constexpr double kLeastFrames = 600;   // short runs are looked at slowed down
constexpr double kMostFrames = 6000;
constexpr std::size_t kMostPoints = 3'000'000;  // of contacts: 40 MB before it is packed
constexpr double kGap = 0.12;                   // between takes, of a take's diagonal
constexpr double kMostSpread = 3;  // a take's width counts up to this times its start's

// How far a body's farthest vertex is from its origin.
double reachOf(const DrawnBody& body) {
  double reach = 0;
  for (const DrawnPart& part : body.parts) {
    if (!part.mesh) continue;
    for (const Vec3& v : part.mesh->vertices)
      reach = std::max(reach, part.pose.toWorld(v).squaredNorm());
  }
  return std::sqrt(reach);
}

Eigen::AlignedBox3d boxOf(const DrawnBody& body, const Pose& at) {
  Eigen::AlignedBox3d box;
  for (const DrawnPart& part : body.parts) {
    if (!part.mesh) continue;
    const Pose pose = at * part.pose;
    for (const Vec3& v : part.mesh->vertices) box.extend(pose.toWorld(v));
  }
  return box;
}

// A patch's disc: a disc of radius R has the second moment R^2 / 2 about its centre in its plane.
ReplayPatch discOf(const PatchNow& patch) {
  double weight = 0;
  Vec3 center = Vec3::Zero(), normal = Vec3::Zero();
  ReplayPatch disc{patch.a, patch.b, static_cast<std::uint32_t>(patch.points.size()), {}, {}, 0, 0};
  double deepest = -1e300;
  for (const ContactNow& c : patch.points) {
    const double w = c.force.norm() + 1e-12;
    weight += w;
    center += w * c.position;
    normal += w * c.normal;
    deepest = std::max(deepest, c.depth);
  }
  center /= weight;
  double moment = 0;
  for (const ContactNow& c : patch.points)
    moment += (c.force.norm() + 1e-12) * (c.position - center).squaredNorm();
  disc.position = center.cast<float>();
  disc.normal = normal.normalized().cast<float>();
  disc.radius = static_cast<float>(std::sqrt(2 * moment / weight));
  disc.depth = static_cast<float>(deepest);
  return disc;
}

void turnAbout(PatchNow& patch) {
  std::swap(patch.a, patch.b);
  for (ContactNow& c : patch.points) c.normal = -c.normal, c.force = -c.force;
}

}  // namespace

struct Recorder::Take {
  ReplayTake take;
  std::vector<Keyframes> motions;  // one a body
  Eigen::AlignedBox3d swept;       // by the origins of what moves
  double interval = 0;             // of frames [s]
  double due = 0;                  // time of the next frame
  long steps = 0;                  // since the last frame
  double narrowPhase = 0;          // the world's clock at the last frame [s]
  double deepest = 0;              // since the last frame
  std::size_t points = 0;          // in all frames
};

Recorder::Recorder() = default;
Recorder::~Recorder() = default;

void Recorder::begin(const World& world, const std::string& label, double seconds, double step) {
  if (take_) endTake();
  take_ = std::make_unique<Take>();
  take_->take.label = label;
  const double frames = std::clamp(kFramesASecond * seconds, kLeastFrames, kMostFrames);
  take_->interval = std::max(step, seconds / frames);
  for (std::size_t i = 0; i < world.bodyCount(); ++i) {
    const DrawnBody& drawn = world.drawn(i);
    take_->take.bodies.push_back({world.name(i), world.isStatic(i), world.mass(i), drawn, {}});
    const Eigen::AlignedBox3d box = boxOf(drawn, world.state(i).pose);
    if (!box.isEmpty()) take_->take.start.extend(box);
  }
  if (take_->take.start.isEmpty()) take_->take.start.extend(Vec3(0, 0, 0));
  const double size = std::max(1e-9, take_->take.start.diagonal().norm());
  for (const ReplayBody& body : take_->take.bodies)
    take_->motions.emplace_back(reachOf(body.drawn), kTolerance * size);
  take_->narrowPhase = world.narrowPhaseSeconds();
}

void Recorder::record(double time, const World& world) {
  Take& t = *take_;
  replay_.seconds = std::max(replay_.seconds, time);
  for (std::size_t i = 0; i < t.motions.size(); ++i) {
    if (world.isStatic(i) && time > 0) continue;
    const Pose pose = world.state(i).pose;
    t.motions[i].add(time, pose);
    if (!world.isStatic(i)) t.swept.extend(pose.position);
  }
  if (time > 0) ++t.steps;
  t.deepest = std::max(t.deepest, world.moment().deepest);
  if (time + 1e-9 * t.interval < t.due) return;
  t.due += t.interval;
  addFrame(time, world);
}

void Recorder::addFrame(double time, const World& world) {
  Take& t = *take_;
  const Energy& energy = world.moment().energy;
  ReplayFrame frame{time, energy.kinetic, energy.potential, energy.spring, t.deepest, 0, {}, {}};
  const double clock = world.narrowPhaseSeconds();
  if (t.steps > 0) frame.narrowPhase = (clock - t.narrowPhase) / double(t.steps);
  t.narrowPhase = clock;
  t.steps = 0;
  t.deepest = 0;
  for (PatchNow& patch : world.contacts()) {
    // The force on what moves is what one looks for.
    if (world.isStatic(static_cast<std::size_t>(patch.b))) turnAbout(patch);
    frame.patches.push_back(discOf(patch));
    for (const ContactNow& c : patch.points)
      frame.points.push_back({c.position.cast<float>(), c.force.cast<float>(), float(c.depth)});
  }
  t.points += frame.points.size();
  t.take.frames.push_back(std::move(frame));
  if (t.points <= kMostPoints) return;
  // Too many: every other instant will do, from here on and back to the start.
  std::vector<ReplayFrame> half;
  t.points = 0;
  for (std::size_t i = 0; i < t.take.frames.size(); i += 2) {
    half.push_back(std::move(t.take.frames[i]));
    t.points += half.back().points.size();
  }
  t.take.frames = std::move(half);
  t.interval *= 2;
}

void Recorder::endTake() {
  Take& t = *take_;
  // Energy is known once a step has been taken.
  if (t.take.frames.size() > 1) {
    ReplayFrame &first = t.take.frames[0], &second = t.take.frames[1];
    std::tie(first.kinetic, first.potential, first.spring, first.narrowPhase) =
        std::tie(second.kinetic, second.potential, second.spring, second.narrowPhase);
  }
  for (std::size_t i = 0; i < t.motions.size(); ++i) {
    t.motions[i].finish();
    t.take.bodies[i].keys = t.motions[i].keys();
  }
  // Beside the takes before it, by as much room as it takes up while it runs.
  Eigen::AlignedBox3d room = t.take.start;
  const Vec3 spread = kMostSpread / 2 * room.sizes();
  const Eigen::AlignedBox3d most(room.center() - spread, room.center() + spread);
  if (!t.swept.isEmpty()) room.extend(t.swept.clamp(most));
  if (!replay_.takes.empty()) {
    const ReplayTake& before = replay_.takes.back();
    const double gap = kGap * room.diagonal().norm();
    t.take.offset.x() = before.offset.x() + before.extent.max().x() + gap - room.min().x();
  }
  t.take.extent = room;
  replay_.takes.push_back(std::move(t.take));
  take_.reset();
}

Replay Recorder::finish() {
  if (take_) endTake();
  return std::move(replay_);
}

}  // namespace cloudcontact::program
