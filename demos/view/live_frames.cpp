// Packs moments and surfaces of a running world (live_frames.h).
#include "view/live_frames.h"

#include <cloudcontact/voxels/display_mesh.h>

#include <cmath>

#include "replay/body_colors.h"
#include "replay/packed_arrays.h"
#include "replay/page_contacts.h"
#include "replay/recorder.h"
#include "replay/shaded_mesh.h"

namespace cloudcontact::program {
namespace {

Json poseJson(const Pose& pose) {
  const Vec3& p = pose.position;
  const auto& q = pose.orientation;
  return {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
}

Json pullsJson(const World& world) {
  Json pulls = Json::array();
  for (std::size_t i = 0; i < world.pulls().size(); ++i) {
    const BodyPull& pull = world.pulls()[i];
    const bool isFelt = i < world.pullForces().size();
    pulls.push_back({{"body", pull.body},
                     {"at", asJson(pull.grip)},
                     {"to", asJson(pull.to)},
                     {"stiffness", pull.stiffness},
                     {"force", isFelt ? world.pullForces()[i].norm() : 0}});
  }
  return pulls;
}

std::vector<std::int8_t> normalsOf(const ShadedMesh& mesh) {
  std::vector<std::int8_t> out;
  out.reserve(3 * mesh.normals.size());
  for (const Eigen::Vector3f& n : mesh.normals)
    for (int axis = 0; axis < 3; ++axis)
      out.push_back(static_cast<std::int8_t>(std::lround(127 * n[axis])));
  return out;
}

std::vector<float> positionsOf(const ShadedMesh& mesh) {
  std::vector<float> out;
  out.reserve(3 * mesh.positions.size());
  for (const Eigen::Vector3f& p : mesh.positions) out.insert(out.end(), p.data(), p.data() + 3);
  return out;
}

// Nobody knows where the bodies will go: half as much again on each side, and down to the planes.
Eigen::AlignedBox3d roomOf(const ReplayTake& take) {
  Eigen::AlignedBox3d room = take.start;
  const Vec3 middle = room.center(), more = 0.25 * room.sizes();
  room.extend(room.min() - more);
  room.extend(room.max() + more);
  for (const ReplayBody& body : take.bodies)
    for (const DrawnPart& part : body.drawn.parts) {
      if (!part.planeNormal) continue;
      const Pose at = body.keys.front().pose * part.pose;
      const Vec3 normal = at.orientation * *part.planeNormal;
      room.extend(middle - normal.dot(middle - at.position) * normal);
    }
  return room;
}

}  // namespace

struct LiveFrames::Surface {
  std::unique_ptr<DisplayMesh> matter;  // null for a body that deforms
  bool isNew = false;                   // not yet told of
  bool isGone = false;                  // told of
};

LiveFrames::LiveFrames(const World& world, double time)
    : world_(world), time_(time), narrowPhase_(world.narrowPhaseSeconds()) {
  for (std::size_t i = 0; i < world.bodyCount(); ++i) addBody(i);
  for (const auto& surface : surfaces_)
    if (surface) surface->isNew = false;  // the page has it
}

LiveFrames::~LiveFrames() = default;

void LiveFrames::addBody(std::size_t i) {
  bodies_.push_back({world_.name(i), world_.isStatic(i), world_.mass(i), world_.drawn(i), {}});
  isFixed_.push_back(world_.isStatic(i));
  surfaces_.push_back(nullptr);
  if (!world_.isCuttable(i) && !world_.isSoft(i)) return;
  surfaces_.back() = std::make_unique<Surface>();
  surfaces_.back()->isNew = true;
  surfaces_.back()->isGone = world_.cutOf(i).gone;
  if (world_.isCuttable(i) && !world_.cutOf(i).gone)
    surfaces_.back()->matter = std::make_unique<DisplayMesh>(world_.matter(i));
}

Replay LiveFrames::start() {
  Recorder recorder;
  recorder.begin(world_, "", 0, 1);
  recorder.record(0, world_);
  Replay replay = recorder.finish();
  replay.isLive = true;
  ReplayTake& take = replay.takes.front();
  still_ = take.contacts.still();
  for (ReplayFrame& frame : take.frames) frame.time = time_;
  take.extent = roomOf(take);
  return replay;
}

std::string LiveFrames::moment(const ViewStatus& status) {
  PackedArrays arrays;
  std::vector<float> poses;
  for (std::size_t i = 0; i < world_.bodyCount(); ++i) {
    const Pose& at = world_.pose(i);
    for (const double v : at.position) poses.push_back(float(v));
    for (const double v : at.orientation.coeffs()) poses.push_back(float(v));
  }
  while (isFixed_.size() < world_.bodyCount()) isFixed_.push_back(world_.isStatic(isFixed_.size()));
  world_.contacts(now_);
  ReplayContacts contacts(still_);
  contacts.add(now_, isFixed_);
  const ContactMoment& moment = world_.moment();
  const double clock = world_.narrowPhaseSeconds();
  Json json = {{"time", status.time},
               {"running", status.isRunning},
               {"ended", status.isEnded},
               {"why", status.why},
               {"speed", status.speed},
               {"factor", status.factor},
               {"pages", status.pages},
               {"said", status.said},
               {"sayings", status.sayings},
               {"kinetic", moment.energy.kinetic},
               {"potential", moment.energy.potential},
               {"spring", moment.energy.spring + moment.energy.elastic},
               {"deepest", moment.deepest},
               {"narrowPhase", clock - narrowPhase_},
               {"steps", status.steps},
               {"poses", arrays.add(poses)},
               {"pulls", pullsJson(world_)},
               {"contacts", contactsJson(contacts, arrays)}};
  narrowPhase_ = clock;
  return arrays.packed(json);
}

bool LiveFrames::hasNewBodies() const {
  return surfaces_.size() < world_.bodyCount();
}

std::vector<std::pair<int, std::string>> LiveFrames::surfaces(bool all) {
  while (hasNewBodies()) {
    isFixed_.resize(surfaces_.size());  // moment() may have been first
    addBody(surfaces_.size());
  }
  std::vector<std::pair<int, std::string>> changed;
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    if (!surfaces_[i]) continue;
    Surface& s = *surfaces_[i];
    bool isChanged = s.isNew || (world_.isSoft(i) && all);
    if (s.matter && !s.isGone) {
      s.isGone = world_.cutOf(i).gone;
      isChanged = isChanged || s.isGone || !s.matter->renew(world_.matter(i)).empty();
    }
    s.isNew = false;
    if (isChanged) changed.emplace_back(static_cast<int>(i), surface(i));
  }
  return changed;
}

std::string LiveFrames::surface(std::size_t i) {
  const Surface& s = *surfaces_[i];
  ShadedMesh mesh;
  if (world_.isSoft(i))
    mesh = shaded(welded(world_.softSurface(i)));
  else if (!s.isGone)
    mesh = shaded(welded(s.matter->mesh()));
  PackedArrays arrays;
  const Json json = {{"surface", i},
                     {"name", world_.name(i)},
                     {"mass", world_.mass(i)},
                     {"gone", s.isGone},
                     {"fixed", world_.isStatic(i)},
                     {"color", bodyColors(bodies_)[i].name},
                     {"cuttable", world_.isCuttable(i)},
                     {"pullable", world_.isPullable(i)},
                     {"place", poseJson(world_.isSoft(i) ? Pose() : world_.matterPlace(i))},
                     {"positions", arrays.add(positionsOf(mesh))},
                     {"normals", arrays.add(normalsOf(mesh))},
                     {"corners", arrays.add(mesh.corners)}};
  return arrays.packed(json);
}

}  // namespace cloudcontact::program
