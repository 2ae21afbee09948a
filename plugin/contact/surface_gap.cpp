// Both trees are walked at once, the nearer boxes first.
#include "contact/surface_gap.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "field/surface_tree.h"
#include "law/triangle_point.h"

namespace cloudcontact {

namespace {

using Corners = SurfaceTree::Corners;

// The nearest points of two segments (Ericson, Real-Time Collision Detection, 5.1.9). Parallel ones
// are nearest at an end, too, which the corners' feet find.
double squareBetween(const Vec3& p, const Vec3& along, const Vec3& q, const Vec3& other, Vec3& onP,
                     Vec3& onQ) {
  const Vec3 r = p - q;
  const double a = along.squaredNorm(), e = other.squaredNorm(), f = other.dot(r);
  const double b = along.dot(other), c = along.dot(r), scale = a * e - b * b;
  double s = scale > 0 ? std::clamp((b * f - c * e) / scale, 0.0, 1.0) : 0;
  const double t = std::clamp((b * s + f) / e, 0.0, 1.0);
  s = std::clamp((b * t - c) / a, 0.0, 1.0);
  onP = p + s * along;
  onQ = q + t * other;
  return (onP - onQ).squaredNorm();
}

class GapSearch {
 public:
  GapSearch(const ContactBody& a, const ContactBody& b, double within)
      : a_(surfaceTree(*a.field)),
        b_(surfaceTree(*b.field)),
        toA_(a.pose.inverse() * b.pose),
        spread_(toA_.orientation.toRotationMatrix().cwiseAbs()),
        best_(within * within) {}

  bool run() {
    struct Pair {
      std::uint32_t a, b;
      double square;
    };
    std::vector<Pair> stack{{0, 0, squareOf(a_.node(0), b_.node(0))}};
    while (!stack.empty()) {
      const Pair pair = stack.back();
      stack.pop_back();
      if (!(pair.square < best_)) continue;
      const SurfaceTree::Node &a = a_.node(pair.a), &b = b_.node(pair.b);
      if (a.count > 0 && b.count > 0) {
        meet(a, b);
        continue;
      }
      const bool splitA = b.count > 0 || (a.count == 0 && a_.boxOf(a).diagonal().norm() >
                                                              b_.boxOf(b).diagonal().norm());
      const std::uint32_t child = splitA ? a.first : b.first;
      Pair near{splitA ? child : pair.a, splitA ? pair.b : child, 0}, far = near;
      ++(splitA ? far.a : far.b);
      near.square = squareOf(a_.node(near.a), b_.node(near.b));
      far.square = squareOf(a_.node(far.a), b_.node(far.b));
      if (far.square < near.square) std::swap(near, far);
      if (far.square < best_) stack.push_back(far);
      if (near.square < best_) stack.push_back(near);
    }
    return found_;
  }

  const Vec3& onA() const { return onA_; }  // A's frame
  const Vec3& onB() const { return onB_; }  // A's frame
  double distance() const { return std::sqrt(best_); }

 private:
  double squareOf(const SurfaceTree::Node& a, const SurfaceTree::Node& b) const {
    const Eigen::AlignedBox3d boxA = a_.boxOf(a), boxB = b_.boxOf(b);
    const Vec3 center = toA_.toWorld(boxB.center()), half = spread_ * boxB.sizes() / 2;
    return boxA.squaredExteriorDistance(
        Eigen::AlignedBox3d(Vec3(center - half), Vec3(center + half)));
  }

  void meet(const SurfaceTree::Node& a, const SurfaceTree::Node& b) {
    for (std::uint32_t j = b.first; j < b.first + b.count; ++j) {
      Corners y = b_.corners(j);
      for (Vec3& corner : y) corner = toA_.toWorld(corner);
      for (std::uint32_t i = a.first; i < a.first + a.count; ++i) meet(a_.corners(i), y);
    }
  }

  void meet(const Corners& x, const Corners& y) {
    Vec3 foot, onX, onY;
    for (std::size_t k = 0; k < 3; ++k) {
      nearestOnTriangle(x[0], x[1], x[2], y[k], foot);
      take((foot - y[k]).squaredNorm(), foot, y[k]);
      nearestOnTriangle(y[0], y[1], y[2], x[k], foot);
      take((foot - x[k]).squaredNorm(), x[k], foot);
      for (std::size_t l = 0; l < 3; ++l) {
        const double square =
            squareBetween(x[k], x[(k + 1) % 3] - x[k], y[l], y[(l + 1) % 3] - y[l], onX, onY);
        take(square, onX, onY);
      }
    }
  }

  void take(double square, const Vec3& onA, const Vec3& onB) {
    if (!(square < best_)) return;
    best_ = square;
    onA_ = onA;
    onB_ = onB;
    found_ = true;
  }

  const SurfaceTree &a_, &b_;
  Pose toA_;
  Eigen::Matrix3d spread_;  // of a box of B by its turn
  double best_;             // square [m^2]
  Vec3 onA_ = Vec3::Zero(), onB_ = Vec3::Zero();
  bool found_ = false;
};

}  // namespace

std::optional<SurfaceGap> surfaceGap(const ContactBody& a, const ContactBody& b, double within) {
  GapSearch search(a, b, within);
  if (!search.run()) return std::nullopt;
  return SurfaceGap{a.pose.toWorld(search.onA()), a.pose.toWorld(search.onB()), search.distance()};
}

}  // namespace cloudcontact
