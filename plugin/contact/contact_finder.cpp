// A query: search, hits, bins, patches, points.
#include <cloudcontact/contact/contact_finder.h>

#include "contact/border_hits.h"
#include "contact/contact_builder.h"
#include "contact/query_memory.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace cloudcontact {

struct ContactWorkspace::State {
  QueryMemoryPool memory;
};

ContactWorkspace::ContactWorkspace() : state_(std::make_unique<State>()) {}
ContactWorkspace::~ContactWorkspace() = default;
ContactWorkspace::ContactWorkspace(ContactWorkspace&&) noexcept = default;
ContactWorkspace& ContactWorkspace::operator=(ContactWorkspace&&) noexcept = default;

void ContactWorkspace::reserve(int threads) {
  state_->memory.reserve(threads);
}

WorkCounts ContactWorkspace::work() const {
  return state_->memory.work();
}

// Samples that count beside touches, and the most searches for them.
struct BesideLook {
  KnownMeets::Look kind;
  int most;
};

struct ContactFinder::State {
  std::shared_ptr<ContactWorkspace> workspace;
  ContactBuilder builder;
  WorkCounts work;         // of all searches
  std::size_t before = 0;  // work.samples when the last one began

  void search(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
              QueryMemory& memory, const TaskRunner* runner, ContactResult& found);
  bool make(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
            const PairFrame& frame, const SearchOutcome& outcome, QueryMemory& memory,
            const TaskRunner* runner, bool beside, ContactResult& found, bool gated = true);
  void lookBeside(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
                  double step, std::span<const BesideLook> looks, ContactResult& contact);
};

// Patches of the memory's hits, as the result or `beside` what it has; `gated`: see Binner. Returns
// whether there are any.
bool ContactFinder::State::make(const ContactBody& a, const ContactBody& b,
                                const ContactSettings& settings, const PairFrame& frame,
                                const SearchOutcome& outcome, QueryMemory& memory,
                                const TaskRunner* runner, bool beside, ContactResult& found,
                                bool gated) {
  const HitColumns& hits = memory.hits;
  const double cell = cellOf(frame, outcome.level);
  memory.binner.patches(hits, cell, a.shape || b.shape, gated, runner);
  std::span<const PatchMatter> matter;
  if (TouchedMatter::wanted(a, b))
    matter = memory.matter.of(a, b, frame, memory.search,
                              {hits, memory.binner, outcome.level, cell, outcome.gap});
  const std::size_t patchesBefore = found.patches.size();
  const double error = found.depthError, pointed = found.pointed;
  if (!beside) found.samples = outcome.gap > 0 ? 0 : outcome.hits, found.level = outcome.level;
  builder.build(a, b, settings, frame, outcome, memory, matter, found);
  if (beside) found.depthError = error, found.pointed = pointed;  // those of the touches
  return found.patches.size() > patchesBefore;
}

ContactFinder::ContactFinder() : ContactFinder(std::make_shared<ContactWorkspace>()) {}
ContactFinder::ContactFinder(std::shared_ptr<ContactWorkspace> workspace)
    : state_(std::make_unique<State>()) {
  state_->workspace = std::move(workspace);
}
ContactFinder::~ContactFinder() = default;
ContactFinder::ContactFinder(ContactFinder&&) noexcept = default;
ContactFinder& ContactFinder::operator=(ContactFinder&&) noexcept = default;

ContactResult ContactFinder::find(const ContactBody& a, const ContactBody& b,
                                  const ContactSettings& settings) {
  ContactResult found;
  find(a, b, settings, found);
  return found;
}

void ContactFinder::find(const ContactBody& a, const ContactBody& b,
                         const ContactSettings& settings, ContactResult& found) {
  search(a, b, settings, found);
  giveIds(found);
}

void ContactFinder::State::search(const ContactBody& a, const ContactBody& b,
                                  const ContactSettings& settings, QueryMemory& memory,
                                  const TaskRunner* runner, ContactResult& found) {
  const PairFrame frame = builder.begin(a, b, settings, found);
  HitColumns& hits = memory.hits;
  const int level =
      memory.search.run(a, b, frame, settings.margin, enoughFor(settings), hits, runner);
  const double gap = addBorderHits(a, b, frame, settings.margin, memory.search.gap(), hits);
  const auto build = [&](double apart, bool gated) {
    found.clear();
    return make(a, b, settings, frame, {level, hits.size(), apart}, memory, runner, false, found,
                gated);
  };
  if (!build(gap, true) && !hits.empty() && gap == 0) {
    bool apart = false;
    // Hits that press nothing must not hide a gap that closes within the step.
    if (settings.margin > 0) {
      std::swap(hits, memory.pressless);
      memory.search.runApart(a, b, frame, settings.margin, hits);
      apart = build(memory.search.gap(), true);
      std::swap(hits, memory.pressless);
    }
    // Of tips that are in each other along one axis no flank faces another: the nearest surface of
    // the other is the flank on the same side. What they push adds up to a force along the axis.
    if (!apart) build(gap, false);
  }
}

void ContactFinder::search(const ContactBody& a, const ContactBody& b,
                           const ContactSettings& settings, ContactResult& found,
                           const TaskRunner* runner) {
  State& s = *state_;
  s.before = s.work.samples;
  BorrowedMemory memory(s.workspace->state_->memory, s.work);
  s.search(a, b, settings, *memory, runner, found);
}

bool ContactFinder::searchTouch(const ContactBody& a, const ContactBody& b,
                                const ContactSettings& settings, ContactResult& found) {
  State& s = *state_;
  BorrowedMemory memory(s.workspace->state_->memory, s.work);
  s.builder.ids().setAside();
  s.search(a, b, settings, *memory, nullptr, memory->trial);
  if (memory->trial.samples > 0) {
    found = memory->trial;
    return true;
  }
  s.builder.ids().setAside();
  return false;
}

namespace {

// Whether a patch is broad both ways: points on one place or on a line resist no turn about it.
bool isBroad(const ContactResult& found, double broad) {
  return std::any_of(found.patches.begin(), found.patches.end(), [&](const Patch& patch) {
    const ContactPoint* const p = found.points.data() + patch.firstPoint;
    return patch.points == 4 &&
           (p[0].position - p[2].position).cross(p[1].position - p[3].position).norm() > broad;
  });
}

}  // namespace

void ContactFinder::lookAround(const ContactBody& a, const ContactBody& b,
                               const ContactSettings& settings, double broad,
                               ContactResult& found) {
  State& s = *state_;
  BorrowedMemory memory(s.workspace->state_->memory, s.work);
  const PairFrame frame = frameOf(a, b);
  memory->search.runApart(a, b, frame, settings.margin, memory->hits);
  if (!(memory->search.gap() > 0)) return;  // a sample is deeper than it said
  ContactResult& around = memory->trial;
  s.builder.ids().setAside();
  s.builder.begin(a, b, settings, around);
  const double gap =
      addBorderHits(a, b, frame, settings.margin, memory->search.gap(), memory->hits);
  s.make(a, b, settings, frame, {0, memory->hits.size(), gap}, *memory, nullptr, false, around);
  if (!isBroad(around, broad)) return s.builder.ids().setAside();
  setHits(found.samples, found.level, around);
  found = around;
}

namespace {

// Most searches beside a touch: a peg in its hole has a wall behind it and a floor. For the other
// ends of walls that a body leans on, of which each peg has up to six beside the pressed ones. And
// for what touches within the step elsewhere. And for the other feet of what stands: those that
// matter are about as near.
constexpr int kMostBeside = 3, kMostFar = 6, kMostAhead = 2, kMostApart = 1;
// [voxels] Slower bodies need no other ends: such near misses let a peg rattle on in its hole.
constexpr double kFarMoves = 2;

// Of samples that move by turn x + shift [m] at x, in the body's frame.
KnownMeets::Way wayOfSamples(const Cloud& cloud, const Eigen::Matrix3d& turn, const Vec3& shift) {
  return {(cloud.voxelSize() * turn).cast<float>(), (turn * cloud.origin() + shift).cast<float>()};
}

// How samples of `own` move against `other` in the step.
void setWays(const ContactBody& own, const ContactBody& other, double step,
             KnownMeets::Side& side) {
  const Cloud& cloud = own.field->cloud();
  const Pose now = other.pose.inverse() * own.pose,
             then = movedOn(other.pose, other.motion, step).inverse() *
                    movedOn(own.pose, own.motion, step);
  const Eigen::Matrix3d back = now.orientation.toRotationMatrix().transpose();
  side.arc =
      wayOfSamples(cloud, back * then.orientation.toRotationMatrix() - Eigen::Matrix3d::Identity(),
                   back * (then.position - now.position));
  const Eigen::Quaterniond toOwn = own.pose.orientation.conjugate();
  const Vec3 spin = step * (toOwn * (own.motion.angular - other.motion.angular));
  const Vec3& origin = own.pose.position;
  Eigen::Matrix3d across;
  across << 0, -spin.z(), spin.y(), spin.z(), 0, -spin.x(), -spin.y(), spin.x(), 0;
  side.line = wayOfSamples(cloud, across,
                           step * (toOwn * (own.motion.at(origin) - other.motion.at(origin))));
}

// What a patch covers, by the covariance of its points.
KnownMeets::Meet meetOf(const Patch& patch, std::span<const ContactPoint> points,
                        const Pose& toGrid, double voxel) {
  KnownMeets::Meet meet;
  meet.normal = (toGrid.orientation * patch.normal).cast<float>();
  Vec3 middle = points.empty() ? patch.position : Vec3::Zero();
  for (const ContactPoint& point : points) middle += point.position / double(points.size());
  meet.place = ((toGrid.orientation * middle + toGrid.position) / voxel).cast<float>();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const ContactPoint& point : points) {
    const Vec3 at = toGrid.orientation * (point.position - middle) / voxel;
    spread += at * at.transpose() / double(points.size());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  for (int k = 0; k < 2; ++k) {
    const double length = std::sqrt(6 * std::max(0.0, axes.eigenvalues()[2 - k]));
    meet.axes[k] = (length * axes.eigenvectors().col(2 - k)).cast<float>();
  }
  return meet;
}

// Adds the patches from `first` on to where the bodies meet.
void addMeets(const ContactBody& own, float outward, const ContactResult& contact,
              std::size_t first, KnownMeets::Side& side) {
  const Cloud& cloud = own.field->cloud();
  Pose toGrid = own.pose.inverse();
  toGrid.position -= cloud.origin();
  for (std::size_t i = first; i < contact.patches.size(); ++i) {
    const Patch& patch = contact.patches[i];
    const std::span points(contact.points.data() + patch.firstPoint, std::size_t(patch.points));
    side.meets.push_back(meetOf(patch, points, toGrid, cloud.voxelSize()));
    side.meets.back().normal *= outward;
  }
}

}  // namespace

// `step` [s]: in which the bodies move on.
void ContactFinder::State::lookBeside(const ContactBody& a, const ContactBody& b,
                                      const ContactSettings& settings, double step,
                                      std::span<const BesideLook> looks, ContactResult& contact) {
  if (contact.patches.empty() || !(settings.margin > 0)) return;
  const PairFrame frame = frameOf(a, b);
  BorrowedMemory memory(workspace->state_->memory, work);
  KnownMeets& known = memory->known;
  for (KnownMeets::Side& side : known.of) side.meets.clear();
  if (a.field) setWays(a, b, step, known.of[kA]);
  if (b.field) setWays(b, a, step, known.of[kB]);
  known.again = false;
  std::size_t first = 0;
  const auto look = [&] {
    if (a.field) addMeets(a, 1, contact, first, known.of[kA]);
    if (b.field) addMeets(b, -1, contact, first, known.of[kB]);
    first = contact.patches.size();
    const bool any = memory->search.runBeside(a, b, frame, settings.margin, known, memory->hits);
    known.again = true;
    const SearchOutcome found{0, memory->hits.size(), memory->search.gap()};
    return any && make(a, b, settings, frame, found, *memory, nullptr, true, contact);
  };
  for (const auto& [kind, most] : looks) {
    if (kind == KnownMeets::Look::Far && settings.margin < kFarMoves * frame.voxel) continue;
    known.look = kind;
    for (int search = 0; search < most && look(); ++search) {
    }
  }
}

void ContactFinder::lookBeside(const ContactBody& a, const ContactBody& b,
                               const ContactSettings& settings, double step,
                               ContactResult& contact) {
  using Look = KnownMeets::Look;
  constexpr BesideLook kLooks[] = {
      {Look::Beside, kMostBeside}, {Look::Far, kMostFar}, {Look::Ahead, kMostAhead}};
  state_->lookBeside(a, b, settings, step, kLooks, contact);
}

void ContactFinder::lookApart(const ContactBody& a, const ContactBody& b,
                              const ContactSettings& settings, ContactResult& contact) {
  constexpr BesideLook kLooks[] = {{KnownMeets::Look::Apart, kMostApart}};
  state_->lookBeside(a, b, settings, 0, kLooks, contact);
}

void ContactFinder::giveIds(ContactResult& found) {
  state_->builder.giveIds(found);
}

const WorkCounts& ContactFinder::work() const {
  return state_->work;
}

std::size_t ContactFinder::sampleLookups() const {
  return state_->work.samples - state_->before;
}

std::size_t ContactFinder::bytesKept() const {
  return sizeof(State) + state_->builder.bytesKept();
}

ContactBuilder& ContactFinder::builder() {
  return state_->builder;
}

double depthOf(const ContactResult& contact) {
  double sum = 0, weight = 0;
  for (const Patch& patch : contact.patches) {
    if (patch.beside) continue;
    sum += patch.stiffness * patch.depth;
    weight += patch.stiffness;
  }
  return weight > 0 ? sum / weight : 0;
}

Wrench wrenchOnB(const ContactResult& contact, const Motion& a, const Motion& b) {
  Wrench w;
  for (const ContactPoint& p : contact.points) {
    const double closing = (a.at(p.position) - b.at(p.position)).dot(p.normal);
    const double size =
        p.depth < 0 ? 0.0 : std::max(0.0, p.stiffness * p.depth + p.damping * closing);
    const Vec3 force = size * p.normal;
    w.force += force;
    w.torque += p.position.cross(force);
  }
  return w;
}

}  // namespace cloudcontact
