// Records poses at every step, reduced to keys on the fly, and contacts and figures at a screen's
// frame rate.
#include "replay/recorder.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace cloudcontact::program {
namespace {

constexpr double kTolerance = 3e-5;    // of the scene's size: 0.03 px at 1000 px
constexpr double kFramesASecond = 60;  // a screen's rate at full speed
constexpr double kLeastFrames = 600;   // short runs are watched in slow motion
constexpr double kMostFrames = 6000;
// Instants at which the surfaces of bodies that are cut or deform are renewed.
constexpr double kMostSurfaces = 60;
constexpr double kGap = 0.12;      // between takes, in diagonals of a take
constexpr double kMostSpread = 3;  // limits a take's width to this multiple of its start's

// Calls visit(vertex) for all that is drawn of a body, in the frame that `at` places.
template <class Visit>
void visitVertices(const World& world, std::size_t body, const Pose& at, const Visit& visit) {
  const auto all = [&](const Mesh& mesh, const Pose& pose) {
    for (const Vec3& v : mesh.vertices) visit(pose.toWorld(v));
  };
  for (const DrawnPart& part : world.drawn(body).parts)
    if (part.mesh) all(*part.mesh, at * part.pose);
  if (world.isSoft(body)) all(world.softSurface(body), at);
  if (world.isCuttable(body) && !world.cutOf(body).gone)
    all(DisplayMesh(world.matter(body)).mesh(), at * world.matterPlace(body));
}

// Distance of a body's farthest vertex from its origin.
double reachOf(const World& world, std::size_t body) {
  double reach = 0;
  visitVertices(world, body, Pose(), [&](const Vec3& v) { reach = std::max(reach, v.norm()); });
  return reach;
}

std::optional<double> massOf(const World& world, std::size_t body) {
  if (world.cutOf(body).gone) return {};
  return world.mass(body);
}

}  // namespace

struct Recorder::Take {
  ReplayTake take;
  std::vector<Keyframes> motions;                           // one for each body
  std::vector<std::unique_ptr<ChangingSurface>> surfaces;   // of each body that is cut
  std::vector<std::vector<SurfacePiece>> softSurfaces;      // of each body that deforms
  double surfaceInterval = 0, surfaceDue = 0, seconds = 0;  // [s]
  double latest = 0, surfacesAt = 0;                        // record(), renewSurfaces() [s]
  double size = 0;                                          // of the scene [m]
  Eigen::AlignedBox3d swept;                                // of the origins of moving bodies
  double interval = 0;                                      // of frames [s]
  double due = 0;                                           // time of the next frame
  long steps = 0;                                           // since the last frame
  double narrowPhase = 0;     // the world's clock at the last frame [s]
  double deepest = 0;         // since the last frame
  std::vector<bool> isFixed;  // of each body
  ContactsNow now;            // reused in each frame

  void addBody(const World& world, double time);
  void renewSurfaces(const World& world, double time);
};

// The next body.
void Recorder::Take::addBody(const World& world, double time) {
  const std::size_t i = motions.size();
  ReplayBody body{world.name(i), world.isStatic(i), world.mass(i), world.drawn(i), {}};
  body.isCuttable = world.isCuttable(i);
  body.isPullable = world.isPullable(i);
  surfaces.push_back(nullptr);
  softSurfaces.emplace_back();
  if (world.isCuttable(i)) {
    surfaces.back() = std::make_unique<ChangingSurface>(world.matter(i), time);
    body.surfacePlace = world.matterPlace(i);
    body.masses.push_back({time, massOf(world, i)});
  }
  take.bodies.push_back(std::move(body));
  motions.emplace_back(reachOf(world, i), kTolerance * size);
  isFixed.push_back(world.isStatic(i));
  if (isFixed.back() && time > 0) motions.back().add(time, world.pose(i));
}

void Recorder::Take::renewSurfaces(const World& world, double time) {
  surfacesAt = time;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    if (world.isSoft(i)) {
      if (!softSurfaces[i].empty()) softSurfaces[i].back().to = time;
      softSurfaces[i].push_back({.from = time, .mesh = shaded(welded(world.softSurface(i)))});
    }
    if (!surfaces[i]) continue;
    std::vector<MassKey>& masses = take.bodies[i].masses;
    if (massOf(world, i) != masses.back().mass) masses.push_back({time, massOf(world, i)});
    if (world.cutOf(i).gone)
      surfaces[i]->end(time);
    else
      surfaces[i]->renew(world.matter(i), time);
  }
}

Recorder::Recorder(std::size_t mostPoints) : mostPoints_(mostPoints) {}
Recorder::~Recorder() = default;

void Recorder::begin(const World& world, const std::string& label, double seconds, double step) {
  if (take_) endTake();
  take_ = std::make_unique<Take>();
  take_->take.label = label;
  const double frames = std::clamp(kFramesASecond * seconds, kLeastFrames, kMostFrames);
  take_->interval = std::max(step, seconds / frames);
  take_->seconds = seconds;
  take_->surfaceInterval = std::max(take_->interval, seconds / kMostSurfaces);
  for (std::size_t i = 0; i < world.bodyCount(); ++i)
    visitVertices(world, i, world.pose(i), [&](const Vec3& v) { take_->take.start.extend(v); });
  if (take_->take.start.isEmpty()) take_->take.start.extend(Vec3(0, 0, 0));
  take_->size = std::max(1e-9, take_->take.start.diagonal().norm());
  for (std::size_t i = 0; i < world.bodyCount(); ++i) take_->addBody(world, 0);
  take_->take.contacts = ReplayContacts(kTolerance * take_->size);
  take_->narrowPhase = world.narrowPhaseSeconds();
}

void Recorder::record(double time, const World& world) {
  Take& t = *take_;
  replay_.seconds = std::max(replay_.seconds, time);
  t.latest = time;
  const bool fell = world.bodyCount() > t.motions.size();
  while (t.motions.size() < world.bodyCount()) t.addBody(world, time);
  if (fell || time >= t.surfaceDue || time >= t.seconds * (1 - 1e-9)) {
    t.renewSurfaces(world, time);
    t.surfaceDue = time + t.surfaceInterval;
  }
  for (std::size_t i = 0; i < t.motions.size(); ++i) {
    if (t.isFixed[i] && time > 0) continue;
    const Pose pose = world.pose(i);
    t.motions[i].add(time, pose);
    if (!t.isFixed[i]) t.swept.extend(pose.position);
  }
  if (time > 0) ++t.steps;
  t.deepest = std::max(t.deepest, world.moment().deepest);
  if (time + 1e-9 * t.interval < t.due) return;
  t.due += t.interval;
  addFrame(time, world);
}

void Recorder::close(const World& world) {
  if (!take_) return;
  Take& t = *take_;
  if (t.surfacesAt < t.latest) t.renewSurfaces(world, t.latest);
  if (!t.take.frames.empty() && t.take.frames.back().time < t.latest) addFrame(t.latest, world);
}

void Recorder::addFrame(double time, const World& world) {
  Take& t = *take_;
  const Energy& energy = world.moment().energy;
  ReplayFrame frame{
      time, energy.kinetic, energy.potential, energy.spring + energy.elastic, t.deepest, 0};
  const double clock = world.narrowPhaseSeconds();
  if (t.steps > 0) frame.narrowPhase = (clock - t.narrowPhase) / double(t.steps);
  t.narrowPhase = clock;
  t.steps = 0;
  t.deepest = 0;
  t.take.frames.push_back(frame);
  world.contacts(t.now);
  ReplayContacts& contacts = t.take.contacts;
  contacts.add(t.now, t.isFixed);
  if (std::max(contacts.points().size(), contacts.shown().size()) <= mostPoints_) return;
  // Too many points: drops every other frame, and doubles the interval.
  contacts.thin();
  std::vector<ReplayFrame>& frames = t.take.frames;
  for (std::size_t i = 1; 2 * i < frames.size(); ++i) {
    const ReplayFrame lost = frames[2 * i - 1];  // a copy, because it is overwritten first
    frames[i] = frames[2 * i];
    frames[i].deepest = std::max(frames[i].deepest, lost.deepest);
    frames[i].narrowPhase = (frames[i].narrowPhase + lost.narrowPhase) / 2;
  }
  if (frames.size() % 2 == 0)
    t.deepest = frames.back().deepest;  // dropped too: counts for the next frame
  frames.resize(contacts.frames());
  t.interval *= 2;
}

void Recorder::endTake() {
  Take& t = *take_;
  // The energy is known after the first step.
  if (t.take.frames.size() > 1) {
    ReplayFrame &first = t.take.frames[0], &second = t.take.frames[1];
    std::tie(first.kinetic, first.potential, first.spring, first.narrowPhase) =
        std::tie(second.kinetic, second.potential, second.spring, second.narrowPhase);
  }
  for (std::size_t i = 0; i < t.motions.size(); ++i) {
    t.motions[i].finish();
    t.take.bodies[i].keys = t.motions[i].keys();
    if (t.surfaces[i]) t.take.bodies[i].surface = t.surfaces[i]->finish();
    if (!t.softSurfaces[i].empty()) t.take.bodies[i].surface = std::move(t.softSurfaces[i]);
  }
  // Next to the previous takes, by the space that it occupies while it runs.
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
