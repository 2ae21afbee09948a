// ContactFinder: hits, bins, patches, points, and the law that turns areas and depths into newtons.
//
// The paper's law (3) is one spring for the pair, FR = k d. Its depth d is that of the deepest
// point, found from the depths' distribution over the area rather than from one sample: if the
// part of the area deeper than t falls like (1 - t/d)^b (b = 0 a face, 1/2 a cylinder's
// side, 1 a sphere or an edge, 2 a corner), then of the moments M_k = sum a t^k
//   M2/M1 = 2 d / (2 + b),  M3/M2 = 3 d / (3 + b),
// which two ratios give b and d. Few samples make a poor rim, and the ratios are taken from it: two
// spheres of 16 voxels pressed 0.3 read up to 7 % too deep. Where both surfaces are smooth there is
// a way past the rim. Depth falls from the deepest point as t(x) = d - x K x / 2, so at every
// sample, wet or hardly so, t + x K x / 2 = d; K is how the normals turn over the patch (1.3 %).
// Such a patch is told by its b: it is x K x / 2 over the mean depth, as it is not at an edge.
//
// The spring is shared out by area, the force by the patches' own sums.
#include <cloudcontact/contact.h>

#include "patch_force.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace cloudcontact {

namespace {

constexpr double kCellVoxels = 8;      // a bin's cell
constexpr double kLeastShare = 0.003;  // of the pair's force: lighter patches are dropped
constexpr double kMostPointed = 2.0;   // b of a corner; noise alone would go on
// Surfaces are smooth where b and what curvature makes of it differ by less than b's noise, one
// over the root of the number of hits, and not where by more than this many times that. Nor where
// their normals lean far apart, as at a corner, whose b may agree by chance: a ball of 10 voxels
// pressed in by one leans by 0.97.
constexpr double kSharp = 1.6, kLeans = 0.93, kLeansFar = 0.87;
// And they are curved where b is more than noise: on a face it is 0.02.
constexpr double kFlat = 0.1, kCurved = 0.3;
// The depth is at most this much more than at the deepest sample itself [voxels].
constexpr double kRim = 0.1;
// Nor is a patch deeper than this many times the pair's depth (a wall wetted over a sliver).
constexpr double kMostDepth = 1.5;
constexpr double kSameCosine = 0.7;  // a patch is last step's if its normal is this near ...
constexpr double kSameVoxels = 8;    // ... and its centre

double deepest(const double* moments) {
  if (!(moments[0] > 0) || !(moments[1] > 0)) return 0;
  const double ratio = moments[2] * moments[0] / (moments[1] * moments[1]);
  const double b =
      ratio >= 1.4 ? kMostPointed : std::clamp(3 * (ratio - 1) / (1.5 - ratio), 0.0, kMostPointed);
  return (1 + 0.5 * b) * moments[1] / moments[0];
}

// A pair's depth as curvature tells it. Sums over all patches.
struct Round {
  int hits = 0;
  double area = 0, volume = 0;                        // [m^2, m^3]
  double square = 0, middle = 0, fall = 0, lean = 0;  // times the volume [m^4, and m^3]

  void add(const Sums& patch, const PatchForce& force, bool oneSided) {
    hits += patch.hits;
    area += patch.area;
    volume += patch.facing;
    square += (oneSided ? 0.5 : 1.0) * (patch.side[0].depth[1] + patch.side[1].depth[1]);
    middle += patch.middle;
    fall += patch.facing * force.fall;
    lean += patch.facing * force.lean;
  }

  // `depth` by the moments, as far as the surfaces are not smooth.
  double correct(double depth) const {
    if (!(square > 0)) return depth;
    const double b = depth * area / volume - 1, bulge = 2 * fall / square;
    const double off = std::abs(b - bulge) * std::sqrt(static_cast<double>(hits));
    const double smooth = std::clamp((kSharp - off) / (kSharp - 1), 0.0, 1.0);
    const double upright = std::clamp((lean / volume - kLeansFar) / (kLeans - kLeansFar), 0.0, 1.0);
    const double curved = std::clamp((bulge - kFlat) / (kCurved - kFlat), 0.0, 1.0);
    return depth + smooth * upright * curved * ((middle + fall) / volume - depth);
  }
};

void check(const ContactBody& body, const char* name) {
  if ((body.field != nullptr) == (body.shape != nullptr))
    throw std::invalid_argument(std::string("ContactFinder::find: body ") + name +
                                " needs either a field or a shape");
  if (!body.pose.position.allFinite() || !body.pose.orientation.coeffs().allFinite())
    throw std::invalid_argument(std::string("ContactFinder::find: the pose of body ") + name +
                                " is not finite");
}

struct FoundPatch {
  const Sums* sums;
  PatchForce force;
  double size;  // |force|

  // Of the pair's spring: by area, and by force where the area is too small for it.
  double share(double allArea, double allForce) const {
    return std::max(sums->area / allArea, size / (kMostDepth * allForce));
  }
};

// A patch of the step before, to keep its points' names.
struct Known {
  Vec3 center, normal;
  std::uint32_t id;
};

}  // namespace

struct ContactFinder::Scratch {
  std::vector<Hit> hits;
  HitSearch search;
  Binner binner;
  std::vector<FoundPatch> found;
  std::vector<Known> known, now;
  std::uint32_t nextId = 0;
  ContactResult result;

  std::uint32_t nameOf(const Vec3& center, const Vec3& normal, double voxel);
  void collect(bool foundation, bool oneSided, Side sampled, double voxel);
  double pairDepth(bool oneSided, double voxel) const;
  void emit(const PairFrame& frame, const ContactSettings& settings, bool oneSided);
};

ContactFinder::ContactFinder() : scratch_(std::make_unique<Scratch>()) {}
ContactFinder::~ContactFinder() = default;
ContactFinder::ContactFinder(ContactFinder&&) noexcept = default;
ContactFinder& ContactFinder::operator=(ContactFinder&&) noexcept = default;

std::uint32_t ContactFinder::Scratch::nameOf(const Vec3& center, const Vec3& normal, double voxel) {
  std::size_t best = known.size();
  double nearest = kSameVoxels * voxel * kSameVoxels * voxel;
  for (std::size_t i = 0; i < known.size(); ++i) {
    const double far = (known[i].center - center).squaredNorm();
    if (far > nearest || known[i].normal.dot(normal) < kSameCosine) continue;
    nearest = far;
    best = i;
  }
  const std::uint32_t id = best < known.size() ? known[best].id : nextId++;
  if (best < known.size()) known.erase(known.begin() + static_cast<std::ptrdiff_t>(best));
  now.push_back({center, normal, id});
  return id;
}

void ContactFinder::Scratch::collect(bool foundation, bool oneSided, Side sampled, double voxel) {
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

// The more coherent body's surface is where depth is measured: by the other body's samples.
double ContactFinder::Scratch::pairDepth(bool oneSided, double voxel) const {
  double moments[2][3] = {}, trust = 0, all = 0, most = -1e300;
  Round round;
  for (const FoundPatch& p : found) {
    for (int s = 0; s < 2; ++s)
      for (int k = 0; k < 3; ++k) moments[s][k] += p.sums->side[s].depth[k];
    most = std::max(most, p.sums->deepest);
    round.add(*p.sums, p.force, oneSided);
    trust += p.size * p.force.trustA;
    all += p.size;
  }
  if (all == 0) return 0;
  trust /= all;
  const double byA = deepest(moments[kA]), byB = deepest(moments[kB]);
  const double depth =
      oneSided || byA == 0 || byB == 0 ? std::max(byA, byB) : trust * byB + (1 - trust) * byA;
  // A rim of samples that hardly touch must not look like a face that is pressed in.
  return std::clamp(most + kRim * voxel, 0.0, round.correct(depth));
}

void ContactFinder::Scratch::emit(const PairFrame& frame, const ContactSettings& settings,
                                  bool oneSided) {
  const bool foundation = settings.law == LawForm::Foundation;
  double force = 0, area = 0;
  for (const FoundPatch& p : found) {
    force += p.size;
    area += p.sums->area;
  }
  const double depth = pairDepth(oneSided, frame.voxel);
  double shares = 0;
  for (const FoundPatch& p : found) shares += p.share(area, force);
  for (const FoundPatch& p : found) {
    Patch patch;
    patch.area = p.sums->area * (oneSided ? 1.0 : 0.5);
    if (foundation) {
      patch.area = std::max(patch.area, p.size / (p.sums->deepest + kRim * frame.voxel));
      patch.stiffness = settings.pair.stiffness * patch.area;
      patch.damping = settings.pair.damping * patch.area;
      patch.depth = p.size / patch.area;
    } else {
      const double share = p.share(area, force) / shares;
      patch.stiffness = settings.pair.stiffness * share;
      patch.damping = settings.pair.damping * share;
      patch.depth = depth * (p.size / force) / share;
    }
    const Vec3 n = p.force.force / p.size;
    const PatchPoints points = pointsOf(*p.sums, p.force, frame.voxel);
    const std::uint32_t id = nameOf(p.force.center, n, frame.voxel);
    patch.normal = frame.pose.orientation * n;
    patch.position = frame.pose.toWorld(p.force.center + n.cross(p.force.torque) / p.size);
    const double pushes = oneSided ? std::max(p.sums->side[0].size, p.sums->side[1].size)
                                   : 0.5 * (p.sums->side[0].size + p.sums->side[1].size);
    patch.confidence = std::min(1.0, p.size / std::max(pushes, 1e-300));
    patch.doubt = p.sums->deep > 0.5 * pushes ? Doubt::Deep
                  : patch.confidence < 0.3    ? Doubt::Opposed
                  : p.sums->hits < 4          ? Doubt::FewSamples
                                              : Doubt::None;
    const double gap = search.gap();
    patch.firstPoint = static_cast<int>(result.points.size());
    patch.points = 4;
    for (int i = 0; i < 4; ++i) {
      ContactPoint point;
      point.position = frame.pose.toWorld(points.position[i]);
      point.normal = frame.pose.orientation * points.normal[i];
      point.depth = patch.depth * points.weight[i] - gap;
      point.stiffness = 0.25 * patch.stiffness;
      point.damping = 0.25 * patch.damping;
      point.id = id * 4 + static_cast<std::uint32_t>(i);
      point.patch = static_cast<int>(result.patches.size());
      result.points.push_back(point);
    }
    patch.depth -= gap;
    result.patches.push_back(patch);
  }
}

const ContactResult& ContactFinder::find(const ContactBody& a, const ContactBody& b,
                                         const ContactSettings& settings) {
  check(a, "A");
  check(b, "B");
  if (a.shape && b.shape)
    throw std::invalid_argument("ContactFinder::find: both bodies are shapes; one must be a cloud");
  Scratch& s = *scratch_;
  s.result.clear();
  s.hits.clear();
  s.found.clear();
  const PairFrame frame = frameOf(a, b);
  // The foundation's force is the gradient of an energy only as far as its sums are exact, at edges
  // above all: with coarser samples a loop over a table's edge does 50 % of its work for nothing.
  const bool foundation = settings.law == LawForm::Foundation;
  const int level = s.search.run(a, b, frame, settings.margin, foundation, s.hits);
  s.result.samples = s.search.gap() > 0 ? 0 : s.hits.size();
  const bool oneSided = a.shape || b.shape;
  const double cell = kCellVoxels * frame.voxel * (level > 1 ? 2 : 1);
  for (const Sums& sums : s.binner.patches(s.hits, cell, oneSided))
    s.found.push_back({&sums, {}, 0});
  s.collect(foundation, oneSided, a.shape ? kB : kA, frame.voxel);
  s.now.clear();
  s.emit(frame, settings, oneSided);
  std::swap(s.known, s.now);
  return s.result;
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
