// ContactFinder: hits, bins, patches, points, and the law that turns areas and depths into newtons.
//
// What becomes of patches is kernels/patch_force.h, contact_depth.h and contact_patch.h.
#include <cloudcontact/contact/contact_finder.h>

#include "contact/finder_scratch.h"
#include "contact/finder_work.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace cloudcontact {

namespace {

constexpr double kCellVoxels = 8;  // a bin's cell

void check(const ContactBody& body, const char* name) {
  if ((body.field != nullptr) == (body.shape != nullptr))
    throw std::invalid_argument(std::string("ContactFinder::find: body ") + name +
                                " needs either a field or a shape");
  if (!body.pose.position.allFinite() || !body.pose.orientation.coeffs().allFinite())
    throw std::invalid_argument(std::string("ContactFinder::find: the pose of body ") + name +
                                " is not finite");
}

CcPlacement placementOf(const Pose& pose) {
  CcPlacement p;
  const Eigen::Matrix3d turn = pose.orientation.toRotationMatrix();
  for (int i = 0; i < 3; ++i) {
    p.shift[i] = pose.position[i];
    for (int j = 0; j < 3; ++j) p.turn[3 * i + j] = turn(i, j);
  }
  return p;
}

Vec3 vec(const double* v) {
  return {v[0], v[1], v[2]};
}

const CcSums* sumsOf(const FoundPatch& patch) {
  return reinterpret_cast<const CcSums*>(patch.sums);
}

}  // namespace

ContactFinder::ContactFinder() : scratch_(std::make_unique<Scratch>()) {}
ContactFinder::~ContactFinder() = default;
ContactFinder::ContactFinder(ContactFinder&&) noexcept = default;
ContactFinder& ContactFinder::operator=(ContactFinder&&) noexcept = default;

CcTerms termsOf(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
                const PairFrame& frame) {
  CcTerms terms{};
  terms.frame = placementOf(frame.pose);
  terms.toA = placementOf(a.pose.inverse() * frame.pose);
  terms.voxel = frame.voxel;
  const KelvinVoigt spring = sharedSpring(settings.law);
  terms.stiffness = spring.stiffness;
  terms.damping = spring.damping;
  terms.foundation = std::holds_alternative<Foundation>(settings.law);
  terms.oneSided = a.shape || b.shape;
  terms.sampled = a.shape ? kB : kA;
  return terms;
}

CcPairSums ContactFinder::Scratch::collect(const CcTerms& terms) {
  double all = 0;
  for (FoundPatch& p : found) {
    p.force = ccForceOf(sumsOf(p), terms.foundation, terms.oneSided, terms.sampled, &p.flat);
    all += p.force.size;
  }
  std::erase_if(found, [&](const FoundPatch& p) {
    return !ccCounts(sumsOf(p), p.force.size, all, terms.voxel, terms.foundation);
  });
  CcPairSums sums = ccNoPatches();
  for (const FoundPatch& p : found)
    ccAddPatch(&sums, sumsOf(p), p.force.size, p.force.trustA, p.force.fall, p.force.lean,
               terms.oneSided);
  return sums;
}

void ContactFinder::Scratch::emit(const CcTerms& terms, CcWhole whole) {
  for (const FoundPatch& p : found) whole.shares += ccShareOf(p.sums->area, p.force.size, &whole);
  for (FoundPatch& p : found) {
    if (p.force.lean == 0) p.flat = ccFlatten(sumsOf(p), p.force.normal);
    CcContactPatch patch;
    ccContactOf(sumsOf(p), &p.force, &p.flat, &terms, &whole, &patch);
    take(patch);
  }
}

void ContactFinder::Scratch::take(const CcContactPatch& from) {
  seen.push_back({vec(from.center), vec(from.seen)});
  Patch patch;
  patch.position = vec(from.position);
  patch.normal = vec(from.normal);
  patch.depth = from.depth;
  patch.stiffness = from.stiffness;
  patch.damping = from.damping;
  patch.area = from.area;
  patch.confidence = from.confidence;
  patch.doubt = static_cast<Doubt>(from.doubt);
  patch.firstPoint = static_cast<int>(result.points.size());
  patch.points = 4;
  ContactPoint point;
  point.stiffness = 0.25 * patch.stiffness;
  point.damping = 0.25 * patch.damping;
  point.patch = static_cast<int>(result.patches.size());
  for (const CcContactPoint& p : from.points) {
    point.position = vec(p.position);
    point.normal = vec(p.normal);
    point.depth = p.depth;
    result.points.push_back(point);
  }
  result.patches.push_back(patch);
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
  return std::holds_alternative<Foundation>(settings.law) ? HitSearch::kAll : settings.samples;
}

double cellOf(const PairFrame& frame, int level) {
  return kCellVoxels * frame.voxel * (level > 1 ? 2 : 1);
}

void ContactFinder::Scratch::finish(const ContactBody& a, const ContactBody& b,
                                    const ContactSettings& settings, const PairFrame& frame,
                                    Hitting hitting, std::span<const Sums> patches,
                                    const HitColumns* hits) {
  CcTerms terms = termsOf(a, b, settings, frame);
  terms.gap = hitting.gap;
  result.samples = terms.gap > 0 ? 0 : hitting.count;
  for (const Sums& sums : patches) found.emplace_back().sums = &sums;
  const CcPairSums all = collect(terms);
  const ShapeInCloud shape{a.shape ? &a : &b, a.shape ? &b : &a, hits, hitting.level};
  const bool touches = terms.oneSided && terms.gap == 0;
  const double depth =
      terms.foundation ? 0
                       : pairDepth(all, touches ? &shape : nullptr, terms.oneSided, frame.voxel);
  emit(terms, {all.size, all.area, 0, depth});
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
