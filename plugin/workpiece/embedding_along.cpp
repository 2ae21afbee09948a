// Each piece sends a line through D, against the direction. The lengths give the depth in two ways.
//
// By moments, where the deepest part of the contact is broad: kernels/contact/contact_depth.h on
// the lengths' uppermost voxel. There a shape is a power law, whatever it is farther up, and the
// mean over many pieces takes out their noise. Pieces count by their area across the direction, and
// steep ones little: their lines are long or short by the noise of their normals.
//
// By the tip, where it is narrow, as of needles, blades and corners: the deepest point lies between
// the pieces' middles and is searched. The surface there is the mean of the pieces around, each
// continued to second order, so that it moves smoothly with the point.
#include "workpiece/embedding_along.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/parallel.h"
#include "kernels/contact/contact_depth.h"
#include "kernels/contact/sample.h"
#include "law/solid_line.h"
#include "workpiece/cloud_tip.h"

namespace cloudcontact {

namespace {

// Lengths are in spacings.
constexpr double kSteep = 0.1, kFlat = 0.4;  // cosines between which a piece gains full weight
constexpr double kTop = 1;                   // of the contact, for the moments
constexpr double kNarrow = 6, kBroad = 12;   // areas of the top: tip below, moments above
constexpr double kSteepTop = 0.3, kFlatTop = 0.2;  // mean spread of the top: likewise
constexpr double kPointed = 1.1, kBlunt = 1.07;    // ratio of the top's moments: likewise
constexpr double kTipRadius = 3;                   // of a cloud's tip
constexpr double kSure = 0.4;                      // length that needs no matter of the body
// A line at most this many times as long as its start is deep in D is no wall's.
constexpr double kAlike = 1.2;
constexpr double kLoose = 0.4;        // length that it may have beside the matter found
constexpr double kInside = 0.75;      // steps from the side of D, to look for matter
constexpr double kShallowest = -0.5;  // length that may still count
constexpr double kMostSlope = 1;      // of the length across a piece
constexpr double kSmooth = 2;         // radius of the mean surface
constexpr double kLevel = 1;          // pieces of one surface differ in height by at most this
constexpr double kBeside = 0.8;       // farthest that a surface is from a piece's middle
constexpr double kFirstStep = 0.5, kLastStep = 0.02;  // of the search for the tip
constexpr double kNear = 3;           // from the tip's first place: pieces that count
constexpr int kFew = 16, kSeeds = 3;  // with fewer pieces in D, each has kSeeds^2 points
constexpr int kWays = 7, kMostTrials = 140;
constexpr std::size_t kTask = 256;  // pieces
constexpr double kOutside = -1e30;

// A piece seen along the direction.
struct SeenPiece {
  double u, v, height;    // of its middle
  double alongU, alongV;  // its slopes
  double weight;          // its area, less if it is steep
  double across;          // times its cosine
  double length, spread;  // of D below its middle, and how much it differs over the piece
};

struct View {
  const PlacedSolid& area;
  Vec3 n, e1, e2;
  double spacing;
  SolidLines lines;
  const std::function<double(const Vec3&)>& matter;

  explicit View(const EmbeddingQuery& q)
      : area(*q.area),
        n(q.outward),
        e1(n.unitOrthogonal()),
        e2(n.cross(e1)),
        spacing(q.spacing),
        lines(area, -n, 0.25 * spacing),
        matter(q.matter) {}
  Vec3 at(double u, double v, double height) const {
    return spacing * (u * e1 + v * e2 + height * n);
  }
  // How far D reaches below a point of the surface in D; kOutside where the point is not in D.
  double lengthBelow(const Vec3& point) const {
    const auto span = lines.through(point);
    return span && span->from <= 0 ? filled(point, span->to / spacing) : kOutside;
  }
  // The same where D may begin below the point: a leaning tool's tip lies under whole material.
  double reachBelow(const Vec3& point) const {
    const auto span = lines.through(point);
    if (!span || span->to < 0 || (span->from > 0 && !matter)) return kOutside;
    return filled(point, span->to / spacing);
  }
  // At most the body's matter along the line, and a little more. On a wall or at the rim of a hole
  // that D fills, a line may be in D by the noise of the surface alone; so the matter is that
  // farther inside D.
  double filled(const Vec3& point, double length) const {
    if (!matter || length < kSure) return length;
    if (length * spacing < kAlike * depthOf(area, point)) return length;
    Vec3 inside = point - 0.5 * length * spacing * n;
    for (int k = 0; k < 2; ++k) {
      const Vec3 normal = normalOf(area, inside);
      inside -= kInside * spacing * (normal - normal.dot(n) * n);
    }
    const int steps = static_cast<int>(std::ceil(4 * length));
    double sum = 0;
    for (int k = 0; k < steps; ++k)
      sum += matter(inside + (0.5 - (k + 0.5) / steps) * length * spacing * n);
    return std::min(length, std::max(kSure, sum * length / steps + kLoose));
  }
};

double spreadOf(const View& view, const Vec3& outward, const Vec3& normal) {
  const double along = normal.dot(outward), leave = std::abs(normal.dot(view.n));
  return 0.5 * std::sqrt(std::max(1 - along * along, 0.0)) / std::max(leave, 1e-9);
}

void measure(const View& view, const PlanePiece& piece, SeenPiece& seen) {
  seen.length = kOutside, seen.spread = 0;
  if (!(seen.weight > 0)) return;
  seen.length = view.lengthBelow(piece.at);
  if (seen.length == kOutside) {
    // Beside the rim the lengths continue below zero; not beside a wall.
    const SolidPoint near = pointOf(view.area, piece.at);
    const double leave = -near.normal.dot(view.n);
    if (near.depth > 0 || leave < 0.5) return;
    seen.length = near.depth / (leave * view.spacing);
    seen.spread = std::min(spreadOf(view, piece.outward, near.normal), 0.5 * kMostSlope);
  } else if (seen.length > kShallowest) {
    const Vec3 normal = normalOf(view.area, piece.at - seen.length * view.spacing * view.n);
    seen.spread = std::min(spreadOf(view, piece.outward, normal), 0.5 * kMostSlope);
  }
}

SeenPiece see(const View& view, const PlanePiece& piece) {
  SeenPiece seen;
  const double cosine = piece.outward.dot(view.n), scale = 1 / std::max(cosine, kSteep);
  const Vec3 at = piece.at / view.spacing;
  seen.u = view.e1.dot(at), seen.v = view.e2.dot(at), seen.height = view.n.dot(at);
  seen.alongU = -scale * view.e1.dot(piece.outward);
  seen.alongV = -scale * view.e2.dot(piece.outward);
  seen.weight = piece.area * ccRamp(cosine, kSteep, kFlat);
  seen.across = seen.weight * cosine;
  measure(view, piece, seen);
  return seen;
}

// How D reaches below a piece.
struct Reach {
  float length, spread, across;
};

struct Moments {
  double of[3] = {0, 0, 0};
  double steep = 0;  // mean spread
  Moments(const std::vector<Reach>& pieces, double from) {
    const auto level = static_cast<float>(from);
    for (const Reach& p : pieces) {
      if (p.length - level <= -p.spread) continue;
      const CcWet wet = ccWet(p.length - level, p.spread);
      const auto across = static_cast<double>(p.across);
      const double first = across * static_cast<double>(wet.depth1);
      of[0] += first, steep += first * static_cast<double>(p.spread);
      of[1] += across * static_cast<double>(wet.depth2);
      of[2] += across * static_cast<double>(wet.depth3);
    }
    if (of[0] > 0) steep /= of[0];
  }
  // Of a face; a little less of what is pointed.
  double area() const { return of[1] > 0 ? of[0] * of[0] / of[1] : 0; }
  // 1 on a face, more the more pointed the contact is (contact_depth.h).
  double ratio() const { return of[1] > 0 ? of[2] * of[0] / (of[1] * of[1]) : 1; }
};

// A place across the direction, and the length of D below the surface there.
struct Tip {
  double u = 0, v = 0, length = kOutside;
};

class TipSearch {
 public:
  // `memory` is for the pieces near the tip.
  TipSearch(const View& view, const std::vector<SeenPiece>& pieces, std::vector<SeenPiece>& memory)
      : view_(view), all_(pieces), near_(&pieces), memory_(memory) {}

  double find() {
    seed();
    if (!(best_.length > 0)) return 0;
    keepNear();
    if (!ends_) best_.length = lengthAt(best_.u, best_.v);
    climb();
    return std::max(sharpened(best_), 0.0);
  }

 private:
  void keepNear() {
    memory_.clear();
    for (const SeenPiece& p : all_)
      if (p.weight > 0 && std::hypot(p.u - best_.u, p.v - best_.v) < kNear) memory_.push_back(p);
    near_ = &memory_;
  }

  void climb() {
    double turn = 0;
    int trials = 0;
    for (double step = kFirstStep; step > kLastStep && trials < kMostTrials; turn += 0.4) {
      const Tip before = best_;
      for (int k = 0; k < kWays; ++k, ++trials) {
        const double angle = turn + 2 * M_PI * k / kWays;
        offer(before.u + step * std::cos(angle), before.v + step * std::sin(angle));
      }
      const bool rose = best_.length > before.length;
      if (ends_ && !rose) break;
      ends_ = false;
      if (!rose) step *= 0.5;
    }
  }

  // The tip of a cloud, which its depth field rounds.
  double sharpened(const Tip& tip) const {
    if (!(tip.length > 0) || !std::holds_alternative<CloudSolid>(view_.area.solid))
      return tip.length;
    const Vec3 top = view_.at(tip.u, tip.v, heightAt(tip.u, tip.v));
    const TipPlace place{top, -view_.n, kTipRadius * view_.spacing};
    return std::max(tip.length,
                    cloudTip(view_.area, place, tip.length * view_.spacing) / view_.spacing);
  }

  // The tip of D if that has a closed form, or the deepest piece; if those are few, the deepest of
  // several points of each.
  void seed() {
    int in = 0;
    for (const SeenPiece& p : all_) {
      in += p.length > 0;
      if (p.length > best_.length) best_ = {p.u, p.v, p.length};
    }
    if (const auto tip = farthestOf(view_.area, -view_.n)) offerEnd(*tip);
    if (in >= kFew || ends_) return;
    for (const SeenPiece& p : all_) {
      if (!(p.weight > 0)) continue;
      for (int k = 0; k < kSeeds * kSeeds; ++k) {
        const double du = (k % kSeeds + 0.5) / kSeeds - 0.5, dv = (k / kSeeds + 0.5) / kSeeds - 0.5;
        const double height = p.height + p.alongU * du + p.alongV * dv;
        const double length = view_.lengthBelow(view_.at(p.u + du, p.v + dv, height));
        if (length > best_.length) best_ = {p.u + du, p.v + dv, length};
      }
    }
  }

  // The end of D against the direction, if it is in the body. A line through it may touch only it.
  void offerEnd(const Vec3& end) {
    const Vec3 at = end / view_.spacing;
    const double u = view_.e1.dot(at), v = view_.e2.dot(at), height = heightAt(u, v);
    if (height == kOutside) return;
    const double length = height - view_.n.dot(at);
    if (!(length > best_.length)) return;
    const Vec3 top = view_.at(u, v, height);
    const auto span = view_.lines.through(top);
    if (!view_.matter && !(span && span->from <= 0)) return;
    const double held = view_.filled(top, length);
    if (held > best_.length) best_ = {u, v, held}, ends_ = held == length;
  }

  void offer(double u, double v) {
    const double length = lengthAt(u, v);
    if (length > best_.length) best_ = {u, v, length};
  }

  struct Surface {
    double height = 0, alongU = 0, alongV = 0;
    const SeenPiece* nearest = nullptr;
    double far = 1e30;  // squared distance to it
  };

  // Each piece continues with the mean of its own slope and that at the place, which is exact for
  // a paraboloid.
  Surface surfaceAt(double u, double v) const {
    Surface s;
    for (const SeenPiece& p : *near_) {
      const double x = u - p.u, y = v - p.v, far = x * x + y * y;
      if (p.weight > 0 && far < s.far) s.nearest = &p, s.far = far;
    }
    if (!s.nearest) return s;
    const SeenPiece& at = *s.nearest;
    const double level = at.height + at.alongU * (u - at.u) + at.alongV * (v - at.v);
    double sum = 0, du = 0, dv = 0;
    for (const SeenPiece& p : *near_) {
      const double x = u - p.u, y = v - p.v, far = x * x + y * y;
      const double rise = p.alongU * x + p.alongV * y;
      if (!(p.weight > 0) || far >= kSmooth * kSmooth) continue;
      if (std::abs(p.height + rise - level) > kLevel) continue;
      const double part = 1 - far / (kSmooth * kSmooth), weight = p.weight * part * part;
      sum += weight, du += weight * x, dv += weight * y;
      s.height += weight * (p.height + 0.5 * rise);
      s.alongU += weight * p.alongU, s.alongV += weight * p.alongV;
    }
    if (!(sum > 0)) return s;
    s.alongU /= sum, s.alongV /= sum;
    s.height = (s.height + 0.5 * (s.alongU * du + s.alongV * dv)) / sum;
    return s;
  }

  // kOutside where there is no surface.
  double heightAt(double u, double v) const {
    Surface s = surfaceAt(u, v);
    if (!s.nearest) return kOutside;
    if (s.far <= kBeside * kBeside) return s.height;
    // Under whole material: the nearest surface goes on as a plane.
    if (!view_.matter) return kOutside;
    const double x = u - s.nearest->u, y = v - s.nearest->v;
    s = surfaceAt(s.nearest->u, s.nearest->v);
    return s.height + s.alongU * x + s.alongV * y;
  }

  double lengthAt(double u, double v) const {
    const double height = heightAt(u, v);
    return height == kOutside ? kOutside : view_.reachBelow(view_.at(u, v, height));
  }

  const View& view_;
  const std::vector<SeenPiece>& all_;
  const std::vector<SeenPiece>* near_;
  std::vector<SeenPiece>& memory_;
  Tip best_;
  bool ends_ = false;  // D ends at best_, which is all where the surface is plane
};

}  // namespace

struct EmbeddingAlong::State {
  std::vector<SeenPiece> pieces, nearTip;
  std::vector<Reach> reaches;
};

EmbeddingAlong::EmbeddingAlong() : state_(std::make_unique<State>()) {}
EmbeddingAlong::~EmbeddingAlong() = default;
EmbeddingAlong::EmbeddingAlong(EmbeddingAlong&&) noexcept = default;
EmbeddingAlong& EmbeddingAlong::operator=(EmbeddingAlong&&) noexcept = default;

void EmbeddingAlong::reserve(std::size_t pieces) {
  state_->pieces.reserve(pieces);
  state_->nearTip.reserve(pieces);
  state_->reaches.reserve(pieces);
}

double EmbeddingAlong::find(const EmbeddingQuery& query, std::span<const PlanePiece> pieces) {
  if (query.outward.isZero() || pieces.empty()) return 0;
  const View view(query);
  std::vector<SeenPiece>& seen = state_->pieces;
  seen.resize(pieces.size());
  parallelFor((pieces.size() + kTask - 1) / kTask, query.threads, [&](std::size_t task, int) {
    const std::size_t end = std::min(pieces.size(), (task + 1) * kTask);
    for (std::size_t k = task * kTask; k < end; ++k) seen[k] = see(view, pieces[k]);
  });
  std::vector<Reach>& reaches = state_->reaches;
  reaches.clear();
  for (const SeenPiece& p : seen)
    if (p.length > kShallowest)
      reaches.push_back({static_cast<float>(p.length), static_cast<float>(p.spread),
                         static_cast<float>(p.across)});
  const Moments all(reaches, 0);
  const double level = ccDeepestByMoments(all.of) - kTop, from = std::max(0.0, level);
  const Moments top = level > 0 ? Moments(reaches, level) : all;
  double broad = ccRamp(top.area(), kNarrow, kBroad) * ccRamp(top.steep, kSteepTop, kFlatTop);
  if (broad > 0)
    broad *= ccRamp((level > 0 ? top : Moments(reaches, level)).ratio(), kPointed, kBlunt);
  double depth = from + ccDeepestByMoments(top.of);
  if (broad < 1)
    depth = broad * depth + (1 - broad) * TipSearch(view, seen, state_->nearTip).find();
  return view.spacing * depth;
}

}  // namespace cloudcontact
