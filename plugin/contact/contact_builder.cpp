// Patches to forces, points and IDs. The arithmetic is in kernels/contact: patch_force.h,
// contact_depth.h and contact_patch.h.
#include "contact/contact_builder.h"

#include <cloudcontact/contact/paper_body.h>

#include "contact/patch_hits.h"
#include "contact/sample_search.h"
#include "field/base_vector_bricks.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace cloudcontact {

namespace {

constexpr double kUnit = 1e-3;  // a quaternion's square of length is 1 but for rounding and drift
constexpr double kCellVoxels = 8;    // a bin's cell
constexpr double kSameCosine = 0.7;  // a patch keeps its ID if its normal agrees this well ...
constexpr double kSameVoxels = 8;    // ... and its center has moved less than this
// The patches' forces add up to FR, (6). Where they oppose each other, as in a wedge, they are
// larger than their sum, by this factor at most.
constexpr double kMostWedge = 4;
constexpr double kPerGap = 0.25;   // error of a gap: near misses lie on planes that are continued
constexpr double kCoherent = 0.3;  // a patch whose base vectors cancel by more is not trusted

void validate(const ContactBody& body, const char* name) {
  if ((body.field != nullptr) == (body.shape != nullptr))
    throw std::invalid_argument(std::string("ContactFinder::find: body ") + name +
                                " needs either a field or a shape");
  if (body.shape) validateBody(*body.shape);
  if (!body.pose.position.allFinite() || !body.pose.orientation.coeffs().allFinite())
    throw std::invalid_argument(std::string("ContactFinder::find: the pose of body ") + name +
                                " is not finite");
  if (!(std::abs(body.pose.orientation.squaredNorm() - 1) < kUnit))
    throw std::invalid_argument(std::string("ContactFinder::find: the orientation of body ") +
                                name + " is not of length 1; normalize it");
  if (!body.pivot.allFinite() || !(body.inverseInertia >= 0) || !std::isfinite(body.inverseInertia))
    throw std::invalid_argument(std::string("ContactFinder::find: body ") + name +
                                " needs a finite pivot and an inverse inertia of 0 or more");
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

void validateMatter(const ContactBody& body) {
  if (body.paper && body.field &&
      !(body.paper->vectors &&
        body.paper->vectors->bricks().bricks == body.field->cloud().bricks()))
    throw std::invalid_argument(
        "ContactFinder::find: the base vectors of ContactBody::paper must be of the field's cloud");
  if (body.tissues && body.tissues->size() > 1 && body.field &&
      body.tissues->size() < body.field->cloud().materials().size())
    throw std::invalid_argument(
        "ContactFinder::find: give one tissue, or one for each of the cloud's materials");
}

// Foundation{} is for bodies whose tissues state stiffness and damping.
void validate(const ContactSettings& settings) {
  const auto* const area = std::get_if<Foundation>(&settings.law);
  if (!(area && area->stiffness == 0 && area->damping == 0)) cloudcontact::validate(settings.law);
  if (settings.samples == 0)
    throw std::invalid_argument("ContactFinder::find: samples is 0; give one at least");
  if (!(settings.margin >= 0))
    throw std::invalid_argument(
        "ContactFinder::find: margin must not be negative or NaN [m]; 0 is none");
}

Vec3 vec(const double* v) {
  return {v[0], v[1], v[2]};
}
Vec3 vec(const CcVec& v) {
  return {v.x, v.y, v.z};
}
CcVec ccVecOf(const Vec3& v) {
  return ccVec(v.x(), v.y(), v.z());
}

Eigen::Matrix2d matrix(const float* m) {
  return Eigen::Matrix2d{{double(m[0]), double(m[1])}, {double(m[2]), double(m[3])}};
}

Eigen::Vector2d pair(const float* v) {
  return {double(v[0]), double(v[1])};
}

PatchTangent tangentOf(const CcPatchTangent& from, const Vec3& normal) {
  const Vec3 t1(double(from.t1[0]), double(from.t1[1]), double(from.t1[2]));
  const float roll[4] = {from.roll[0], from.roll[1], from.roll[1], from.roll[2]};
  PatchTangent to;
  to.along[0] = t1, to.along[1] = normal.cross(t1);
  to.middle = pair(from.middle), to.aside = pair(from.aside);
  to.roll = matrix(roll), to.tilt = matrix(from.tilt);
  to.bend = matrix(from.bend), to.lean = matrix(from.lean);
  to.trustA = double(from.trustA), to.perDepth = double(from.perDepth);
  to.twist = double(from.twist);
  return to;
}

// The patch's force along its digital normal, through the same center of pressure, with the spin
// of its base vectors.
CcPatchForce directed(const CcPatchForce& force, const PatchMatter& matter, double size) {
  CcPatchForce out = force;
  const Vec3 n = matter.vectors.normalized();
  const Vec3 arm =
      force.size > 0 ? Vec3(vec(force.normal).cross(vec(force.torque)) / force.size) : Vec3::Zero();
  const Vec3 pressure = vec(force.center) + arm;
  const Vec3 spin = matter.moment - pressure.cross(matter.vectors);
  out.normal = ccVecOf(n);
  out.size = size;
  out.torque = ccVecOf(Vec3(arm.cross(size * n) + size * spin.dot(n) / matter.vectors.norm() * n));
  return out;
}

}  // namespace

void PatchIds::give(ContactResult& found, double voxel) {
  for (std::size_t n = 0; n < now_.size(); ++n) {
    Place& place = now_[n];
    std::size_t best = known_.size();
    double nearest = kSameVoxels * voxel * kSameVoxels * voxel;
    for (std::size_t i = 0; i < known_.size(); ++i) {
      const double far = (known_[i].middle - place.middle).squaredNorm();
      if (far > nearest || known_[i].normal.dot(place.normal) < kSameCosine) continue;
      nearest = far;
      best = i;
    }
    const bool isKnown = best < known_.size();
    place.id = isKnown ? known_[best].id : next_++;
    if (isKnown) known_.erase(known_.begin() + static_cast<std::ptrdiff_t>(best));
    const Patch& patch = found.patches.at(n);
    for (int k = 0; k < patch.points; ++k)
      found.points.at(static_cast<std::size_t>(patch.firstPoint + k)).id =
          place.id * 4 + static_cast<std::uint32_t>(k);
  }
  known_ = now_;
}

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
  const ContactBody* const bodies[2] = {&a, &b};
  for (int side = 0; side < 2; ++side) {
    const ContactBody& body = *bodies[side];
    const Vec3 pivot = frame.pose.toLocal(body.pose.toWorld(body.pivot));
    for (int k = 0; k < 3; ++k) terms.pivots[side][k] = pivot[k];
    const bool isPlane = body.shape && std::holds_alternative<HalfSpace>(*body.shape);
    terms.eases[side] = isPlane ? 0 : body.inverseInertia;  // a plane has no end
  }
  return terms;
}

// The foundation's force is the gradient of an energy only as far as its sums are exact, above all
// at edges. With coarser samples, half of the work of a loop over a table's edge is false.
std::size_t enoughFor(const ContactSettings& settings) {
  return std::holds_alternative<Foundation>(settings.law) ? search::kAllSamples : settings.samples;
}

double cellOf(const PairFrame& frame, int level) {
  return kCellVoxels * frame.voxel * (level > 1 ? 2 : 1);
}

PairFrame ContactBuilder::begin(const ContactBody& a, const ContactBody& b,
                                const ContactSettings& settings, ContactResult& found) {
  validate(a, "A");
  validate(b, "B");
  validateMatter(a);
  validateMatter(b);
  validate(settings);
  if (a.shape && b.shape)
    throw std::invalid_argument("ContactFinder::find: both bodies are shapes; one must be a cloud");
  found.clear();
  ids_.begin();
  const PairFrame frame = frameOf(a, b);
  voxel_ = frame.voxel;
  return frame;
}

// What patches have touched that do not count belongs to all others.
void ContactBuilder::giveMatter(std::span<const PatchMatter> matter) {
  if (matter.empty()) return;
  PatchMatter rest;
  double all = 0;
  std::size_t next = 0;
  for (FoundPatch& p : found_) {
    for (; next < p.index; ++next) rest.add(matter[next]);
    p.matter = matter[next++];
    all += p.matter.count[kA] + p.matter.count[kB];
  }
  for (; next < matter.size(); ++next) rest.add(matter[next]);
  if (all > 0)
    for (FoundPatch& p : found_)
      p.matter.add(rest, (p.matter.count[kA] + p.matter.count[kB]) / all);
}

// Gives every patch its digital normal and its part of FR (6), in proportion to its sum of base
// vectors. Returns the force's size. Without any the samples' own normals stay: returns 0.
double ContactBuilder::redirect() {
  double size = 0, lengths = 0;
  Vec3 sum = Vec3::Zero();
  for (const FoundPatch& p : found_) {
    size += p.force.size;
    lengths += p.matter.vectors.norm();
    sum += p.matter.vectors;
  }
  if (!(lengths > 0)) return 0;
  const double wedge = std::min(kMostWedge, lengths / std::max(sum.norm(), 1e-300));
  for (FoundPatch& p : found_) {
    const double length = p.matter.vectors.norm();
    p.force = directed(p.force, p.matter, size * wedge * length / lengths);
    if (length > 0 && p.force.lean != 0) p.flat = ccFlatten(p.sums, p.force.normal);
  }
  std::erase_if(found_, [](const FoundPatch& p) { return !(p.force.size > 0); });
  return size;
}

// k and c by the tissues: of each patch by what it touches, or of `whole` pair alike, as the paper
// has it.
void ContactBuilder::setSprings(const ContactBody& a, const ContactBody& b, bool whole) {
  PatchMatter all;
  for (const FoundPatch& p : found_) all.add(p.matter);
  for (FoundPatch& p : found_) {
    const bool known =
        (!wantsVoxels(a) || p.matter.count[kA] > 0) && (!wantsVoxels(b) || p.matter.count[kB] > 0);
    p.spring = springOf(whole || !known ? all : p.matter, a, b);
  }
}

CcPairSums ContactBuilder::collect(const CcTerms& terms) {
  double all = 0;
  for (FoundPatch& p : found_) {
    p.force = ccForceOf(p.sums, terms.foundation, terms.oneSided, terms.sampled, &p.flat);
    all += p.force.size;
  }
  std::erase_if(found_, [&](const FoundPatch& p) {
    return !ccCounts(p.sums, p.force.size, all, terms.voxel, terms.foundation);
  });
  CcPairSums sums = ccNoPatches();
  for (const FoundPatch& p : found_)
    ccAddPatch(&sums, p.sums, p.force.size, p.force.trustA, p.force.fall, p.force.lean,
               terms.oneSided);
  return sums;
}

namespace {

// See PairDepth::ended.
void takeEnd(double ended, float end, CcContactPatch& patch) {
  patch.depth += ended * (static_cast<double>(end) - patch.depth);
  for (CcContactPoint& point : patch.points) point.depth += ended * (1 - point.depth);
}

}  // namespace

void ContactBuilder::emit(const CcTerms& terms, CcWhole whole, double ended, bool redirected,
                          double cell, QueryMemory& memory, ContactResult& result) {
  PatchHits& wet = memory.wet;
  const PairHits hits{&memory.binner, &memory.hits, cell};
  for (const FoundPatch& p : found_) whole.shares += ccShareOf(p.sums->area, p.force.size, &whole);
  contacts_.clear();
  double level = 0;
  for (FoundPatch& p : found_) {
    if (p.force.lean == 0) p.flat = ccFlatten(p.sums, p.force.normal);
    CcTerms own = terms;
    if (p.spring) own.stiffness = p.spring->stiffness, own.damping = p.spring->damping;
    CcContactPatch& patch = contacts_.emplace_back();
    wet.take(hits, p.index);
    CcPlan plan = ccPlanOf(p.sums, &p.force, &p.flat, ccLeverOf(&own, &p.force), own.voxel);
    plan.apart = own.gap > 0 && ccIsFlat(&p.flat, own.voxel);
    CcNearestHit found[4];
    wet.place(p.force, p.flat, plan, found);
    ccContactOf(p.sums, &p.force, &p.flat, &plan, found, &own, &whole, &patch);
    if (ended > 0) takeEnd(ended, wet.largestOf(memory.search.ends()), patch);
    level = std::max(level, ccLevelling(&patch, &own, &whole));
    if (redirected) {
      patch.confidence = std::min(1.0, p.matter.vectors.norm() / p.matter.lengths);
      if (patch.confidence < kCoherent && patch.doubt != CC_DEEP_PATCH) patch.doubt = CC_OPPOSED;
    }
  }
  for (CcContactPatch& patch : contacts_) {
    ccLevelDepths(&patch, &terms, &whole, level);
    add(patch, result);
  }
}

void setHits(std::size_t hits, int level, ContactResult& found) {
  const auto isGap = [](const Patch& patch) { return patch.depth < 0; };
  const bool apart =
      !found.patches.empty() && std::all_of(found.patches.begin(), found.patches.end(), isGap);
  found.samples = apart ? 0 : hits;
  found.level = level;
  for (Patch& patch : found.patches) patch.beside = found.samples > 0 && isGap(patch);
}

void ContactBuilder::add(const CcContactPatch& from, ContactResult& result) {
  ids_.add(vec(from.center), vec(from.seen));
  result.depthError = from.error;
  result.pointed = from.pointed;
  Patch patch;
  patch.position = vec(from.position);
  patch.normal = vec(from.normal);
  patch.depth = from.depth;
  patch.stiffness = from.stiffness;
  patch.damping = from.damping;
  patch.area = from.area;
  patch.confidence = from.confidence;
  patch.doubt = static_cast<Doubt>(from.doubt);
  patch.beside = result.samples > 0 && from.depth < 0;
  patch.firstPoint = static_cast<int>(result.points.size());
  patch.points = 4;
  patch.tangent = tangentOf(from.tangent, patch.normal);
  ContactPoint point;
  point.slope = 0.25 * from.slope;
  point.damping = 0.25 * from.damping;
  point.patch = static_cast<int>(result.patches.size());
  for (const CcContactPoint& p : from.points) {
    point.position = vec(p.position);
    point.normal = vec(p.normal);
    point.depth = p.depth;
    point.stiffness = p.stiffness;
    result.points.push_back(point);
  }
  result.patches.push_back(patch);
}

void ContactBuilder::build(const ContactBody& a, const ContactBody& b,
                           const ContactSettings& settings, const PairFrame& frame,
                           SearchOutcome outcome, QueryMemory& memory,
                           std::span<const PatchMatter> matter, ContactResult& result) {
  const Binner& binner = memory.binner;
  const HitColumns& hits = memory.hits;
  CcTerms terms = termsOf(a, b, settings, frame);
  terms.gap = outcome.gap;
  found_.clear();
  const std::vector<CcSums>& patches = binner.patches();
  for (std::size_t k = 0; k < patches.size(); ++k) {
    FoundPatch& found = found_.emplace_back();
    found.sums = &patches[k];
    found.index = k;
  }
  const CcPairSums all = collect(terms);
  giveMatter(matter);
  const PairDepth found = pairDepth(all, {&a, &b, &frame, &hits, outcome.level}, terms);
  const bool vectors = (a.paper || b.paper) && !matter.empty();
  if (a.tissues || b.tissues) setSprings(a, b, vectors && !terms.foundation);
  const double size = vectors ? redirect() : 0;
  const CcWhole whole = ccWholeOf(&all, size > 0 ? size : all.size, found.depth,
                                  found.error + kPerGap * terms.gap, &terms);
  // Border hits are no samples.
  const double ended = memory.search.ends().size() == hits.size() ? found.ended : 0;
  emit(terms, whole, ended, size > 0, cellOf(frame, outcome.level), memory, result);
}

}  // namespace cloudcontact
