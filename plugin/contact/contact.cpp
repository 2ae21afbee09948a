// ContactFinder: hits, bins, patches, points, and the law that turns areas and depths into newtons.
//
// The paper's law (3) is one spring for the pair, FR = k d (pair_depth.h has d). The spring is
// shared out by area, the force by the patches' own sums.
#include <cloudcontact/contact.h>

#include "finder_scratch.h"
#include "finder_work.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace cloudcontact {

namespace {

constexpr double kCellVoxels = 8;      // a bin's cell
constexpr double kLeastShare = 0.003;  // of the pair's force: lighter patches are dropped
// No patch is deeper than this many times the pair's depth (a wall wetted over a sliver).
constexpr double kMostDepth = 1.5;

void check(const ContactBody& body, const char* name) {
  if ((body.field != nullptr) == (body.shape != nullptr))
    throw std::invalid_argument(std::string("ContactFinder::find: body ") + name +
                                " needs either a field or a shape");
  if (!body.pose.position.allFinite() || !body.pose.orientation.coeffs().allFinite())
    throw std::invalid_argument(std::string("ContactFinder::find: the pose of body ") + name +
                                " is not finite");
}

// A patch's share of the pair's spring: by area, and by force where the area is too small for it.
double shareOf(const FoundPatch& p, double allArea, double allForce) {
  return std::max(p.sums->area / allArea, p.size / (kMostDepth * allForce));
}

}  // namespace

ContactFinder::ContactFinder() : scratch_(std::make_unique<Scratch>()) {}
ContactFinder::~ContactFinder() = default;
ContactFinder::ContactFinder(ContactFinder&&) noexcept = default;
ContactFinder& ContactFinder::operator=(ContactFinder&&) noexcept = default;

void ContactFinder::Scratch::collect(bool foundation, bool oneSided, Side sampled) {
  double all = 0;
  for (FoundPatch& p : found) {
    p.force = forceOf(*p.sums, foundation, oneSided, sampled);
    p.size = p.force.force.norm();
    all += p.size;
  }
  const double least = foundation ? 0 : kLeastShare;  // the energy's gradient leaves nothing out
  std::erase_if(found, [&](const FoundPatch& p) {
    return !(p.size > least * all) || !(p.sums->area > 0) || !(p.sums->deepest > -kRim * voxel);
  });
}

void ContactFinder::Scratch::emit(const PairFrame& frame, const Pose& poseOfA,
                                  const ContactSettings& settings, double depth, bool oneSided) {
  const bool foundation = settings.law == LawForm::Foundation;
  double force = 0, area = 0;
  for (const FoundPatch& p : found) {
    force += p.size;
    area += p.sums->area;
  }
  const Pose toA = poseOfA.inverse() * frame.pose;
  double shares = 0;
  for (const FoundPatch& p : found) shares += shareOf(p, area, force);
  for (const FoundPatch& p : found) {
    Patch patch;
    patch.area = p.sums->area * (oneSided ? 1.0 : 0.5);
    if (foundation) {
      const double deepest = std::max(0.0, p.sums->deepest) + kRim * frame.voxel;
      patch.area = std::max(patch.area, p.size / deepest);
      patch.stiffness = settings.pair.stiffness * patch.area;
      patch.damping = settings.pair.damping * patch.area;
      patch.depth = p.size / patch.area;
    } else {
      const double share = shareOf(p, area, force) / shares;
      patch.stiffness = settings.pair.stiffness * share;
      patch.damping = settings.pair.damping * share;
      patch.depth = depth * (p.size / force) / share;
    }
    const Vec3 n = p.force.force / p.size;
    const PatchPoints points = pointsOf(*p.sums, p.force, frame.voxel);
    seen.push_back({toA.toWorld(p.force.center), toA.orientation * n});
    patch.normal = frame.pose.orientation * n;
    patch.position = frame.pose.toWorld(p.force.center + n.cross(p.force.torque) / p.size);
    const double pushes = oneSided ? std::max(p.sums->side[0].size, p.sums->side[1].size)
                                   : 0.5 * (p.sums->side[0].size + p.sums->side[1].size);
    patch.confidence = std::min(1.0, p.size / std::max(pushes, 1e-300));
    patch.doubt = p.sums->deep > 0.5 * pushes ? Doubt::Deep
                  : patch.confidence < 0.3    ? Doubt::Opposed
                  : p.sums->hits < 4          ? Doubt::FewSamples
                                              : Doubt::None;
    patch.firstPoint = static_cast<int>(result.points.size());
    patch.points = 4;
    for (int i = 0; i < 4; ++i) {
      ContactPoint point;
      point.position = frame.pose.toWorld(points.position[i]);
      point.normal = frame.pose.orientation * points.normal[i];
      point.depth = patch.depth * points.weight[i] - gap;
      point.stiffness = 0.25 * patch.stiffness;
      point.damping = 0.25 * patch.damping;
      point.patch = static_cast<int>(result.patches.size());
      result.points.push_back(point);
    }
    patch.depth -= gap;
    result.patches.push_back(patch);
  }
}

PairFrame ContactFinder::Scratch::begin(const ContactBody& a, const ContactBody& b) {
  check(a, "A");
  check(b, "B");
  if (a.shape && b.shape)
    throw std::invalid_argument("ContactFinder::find: both bodies are shapes; one must be a cloud");
  result.clear();
  found.clear();
  asked = 0;
  seen.clear();
  const PairFrame frame = frameOf(a, b);
  voxel = frame.voxel;
  return frame;
}

// The foundation's force is the gradient of an energy only as far as its sums are exact, at edges
// above all: with coarser samples a loop over a table's edge does 50 % of its work for nothing.
std::size_t enoughFor(const ContactSettings& settings) {
  return settings.law == LawForm::Foundation ? HitSearch::kAll : settings.samples;
}

double cellOf(const PairFrame& frame, int level) {
  return kCellVoxels * frame.voxel * (level > 1 ? 2 : 1);
}

void ContactFinder::Scratch::finish(const ContactBody& a, const ContactBody& b,
                                    const ContactSettings& settings, const PairFrame& frame,
                                    Hitting hitting, std::span<const Sums> patches,
                                    const HitColumns* hits) {
  const bool foundation = settings.law == LawForm::Foundation, oneSided = a.shape || b.shape;
  gap = hitting.gap;
  result.samples = gap > 0 ? 0 : hitting.count;
  for (const Sums& sums : patches) found.push_back({&sums, {}, 0});
  collect(foundation, oneSided, a.shape ? kB : kA);
  const ShapeInCloud shape{a.shape ? &a : &b, a.shape ? &b : &a, hits, hitting.level};
  const bool touches = oneSided && gap == 0;
  // The foundation has no depth of a pair: each patch's own is its force over its area.
  const double depth =
      foundation ? 0 : pairDepth(found, touches ? &shape : nullptr, oneSided, frame.voxel);
  emit(frame, a.pose, settings, depth, oneSided);
}

const ContactResult& ContactFinder::Scratch::named() {
  names.name(seen, voxel);
  for (ContactPoint& point : result.points) {
    const auto patch = static_cast<std::size_t>(point.patch);
    const int place =
        static_cast<int>(&point - result.points.data()) - result.patches[patch].firstPoint;
    point.id = seen[patch].id * 4 + static_cast<std::uint32_t>(place);
  }
  return result;
}

const ContactResult& ContactFinder::find(const ContactBody& a, const ContactBody& b,
                                         const ContactSettings& settings) {
  search(a, b, settings);
  return named();
}

void ContactFinder::search(const ContactBody& a, const ContactBody& b,
                           const ContactSettings& settings, const TaskRunner* shareOut) {
  Scratch& s = *scratch_;
  const PairFrame frame = s.begin(a, b);
  BorrowedWork work;
  const int level = work->search.run(a, b, frame, settings.margin, enoughFor(settings), work->hits,
                                     shareOut, settings.lists ? &s.lists : nullptr);
  const std::vector<Sums>& patches =
      work->binner.patches(work->hits, cellOf(frame, level), a.shape || b.shape, shareOut);
  s.asked = work->search.asked();
  s.finish(a, b, settings, frame, {level, work->hits.size(), work->search.gap()}, patches,
           &work->hits);
}

const ContactResult& ContactFinder::named() {
  return scratch_->named();
}

std::size_t ContactFinder::asked() const {
  return scratch_->asked;
}

void ContactFinder::makeRoom(int threads) {
  levelWorks(threads);
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
