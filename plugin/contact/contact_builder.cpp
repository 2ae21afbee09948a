// Patches to forces, points and IDs. The arithmetic is in kernels/contact: patch_force.h,
// contact_depth.h and contact_patch.h.
#include "contact/contact_builder.h"

#include "contact/sample_search.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace cloudcontact {

namespace {

constexpr double kCellVoxels = 8;    // a bin's cell
constexpr double kSameCosine = 0.7;  // a patch keeps its ID if its normal agrees this well ...
constexpr double kSameVoxels = 8;    // ... and its center has moved less than this

void validate(const ContactBody& body, const char* name) {
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

}  // namespace

void PatchIds::assign(std::vector<Patch>& patches, double voxel) {
  for (Patch& patch : patches) {
    std::size_t best = known_.size();
    double nearest = kSameVoxels * voxel * kSameVoxels * voxel;
    for (std::size_t i = 0; i < known_.size(); ++i) {
      const double far = (known_[i].center - patch.center).squaredNorm();
      if (far > nearest || known_[i].normal.dot(patch.normal) < kSameCosine) continue;
      nearest = far;
      best = i;
    }
    if (best == known_.size()) {
      patch.id = next_++;
      continue;
    }
    patch.id = known_[best].id;
    known_.erase(known_.begin() + static_cast<std::ptrdiff_t>(best));
  }
  known_.assign(patches.begin(), patches.end());
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

PairFrame ContactBuilder::begin(const ContactBody& a, const ContactBody& b) {
  validate(a, "A");
  validate(b, "B");
  if (a.shape && b.shape)
    throw std::invalid_argument("ContactFinder::find: both bodies are shapes; one must be a cloud");
  result_.clear();
  found_.clear();
  patches_.clear();
  const PairFrame frame = frameOf(a, b);
  voxel_ = frame.voxel;
  return frame;
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

void ContactBuilder::emit(const CcTerms& terms, CcWhole whole) {
  for (const FoundPatch& p : found_) whole.shares += ccShareOf(p.sums->area, p.force.size, &whole);
  for (FoundPatch& p : found_) {
    if (p.force.lean == 0) p.flat = ccFlatten(p.sums, p.force.normal);
    CcContactPatch patch;
    ccContactOf(p.sums, &p.force, &p.flat, &terms, &whole, &patch);
    add(patch);
  }
}

void ContactBuilder::add(const CcContactPatch& from) {
  patches_.push_back({vec(from.center), vec(from.seen)});
  Patch patch;
  patch.position = vec(from.position);
  patch.normal = vec(from.normal);
  patch.depth = from.depth;
  patch.stiffness = from.stiffness;
  patch.damping = from.damping;
  patch.area = from.area;
  patch.confidence = from.confidence;
  patch.doubt = static_cast<Doubt>(from.doubt);
  patch.firstPoint = static_cast<int>(result_.points.size());
  patch.points = 4;
  ContactPoint point;
  point.stiffness = 0.25 * patch.stiffness;
  point.damping = 0.25 * patch.damping;
  point.patch = static_cast<int>(result_.patches.size());
  for (const CcContactPoint& p : from.points) {
    point.position = vec(p.position);
    point.normal = vec(p.normal);
    point.depth = p.depth;
    result_.points.push_back(point);
  }
  result_.patches.push_back(patch);
}

void ContactBuilder::build(const ContactBody& a, const ContactBody& b,
                           const ContactSettings& settings, const PairFrame& frame,
                           SearchOutcome outcome, std::span<const CcSums> patches,
                           const HitColumns* hits) {
  CcTerms terms = termsOf(a, b, settings, frame);
  terms.gap = outcome.gap;
  result_.samples = terms.gap > 0 ? 0 : outcome.hits;
  for (const CcSums& sums : patches) found_.emplace_back().sums = &sums;
  const CcPairSums all = collect(terms);
  const ShapeInCloud shape{a.shape ? &a : &b, a.shape ? &b : &a, hits, outcome.level};
  const bool touches = terms.oneSided && terms.gap == 0;
  const double depth =
      terms.foundation ? 0
                       : pairDepth(all, touches ? &shape : nullptr, terms.oneSided, frame.voxel);
  emit(terms, {all.size, all.area, 0, depth});
}

const ContactResult& ContactBuilder::withIds() {
  ids_.assign(patches_, voxel_);
  for (ContactPoint& point : result_.points) {
    const auto patch = static_cast<std::size_t>(point.patch);
    const int place =
        static_cast<int>(&point - result_.points.data()) - result_.patches[patch].firstPoint;
    point.id = patches_[patch].id * 4 + static_cast<std::uint32_t>(place);
  }
  return result_;
}

}  // namespace cloudcontact
