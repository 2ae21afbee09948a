// Quadrics through the points of a scan: see scan_surface.h.
//
// The first estimate of a normal is the direction in which the neighbors spread least. Around each
// point a quadric is then fitted by least squares to the neighbors with similar normals, so an edge
// has pieces for both of its faces. Planes instead of quadrics would put the surface of a ball
// outside the ball. The height of a position is the mean over the pieces around its nearest point,
// weighted by their distance.
#include "objects/scan_surface.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace cloudcontact {

namespace {

constexpr std::size_t kFewest = 9;       // neighbors for a normal
constexpr std::size_t kForQuadric = 12;  // neighbors for a quadric
constexpr double kSameFace = 0.8;        // cosine of 37 deg between normals of one face
constexpr double kBlend = 1.5;           // radius of the blended pieces, in point distances
constexpr double kWalk = 4;              // range of the search for a side, in cells

using Vec6 = Eigen::Matrix<double, 6, 1>;

Vec6 powers(double u, double v) {
  Vec6 p;
  p << 1, u, v, u * u, u * v, v * v;
  return p;
}

void tangents(const Vec3& n, Vec3& t1, Vec3& t2) {
  t1 = n.unitOrthogonal();
  t2 = n.cross(t1);
}

}  // namespace

ScanSurface::ScanSurface(const std::vector<Vec3>& points, const std::vector<Vec3>& normals,
                         double distance, double smoothing, int threads)
    : points_(points),
      pieces_(points.size()),
      tree_(points),
      distance_(distance),
      smoothing_(smoothing),
      threads_(threads) {
  if (normals.empty()) {
    findNormals();
  } else {
    for (std::size_t i = 0; i < points.size(); ++i) pieces_[i].normal = normals[i];
  }
}

void ScanSurface::findNormals() {
  parallelFor(points_.size(), threads_, [&](std::size_t i, int) {
    Vec3 sum = Vec3::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    double count = 0;
    const auto add = [&](std::size_t k) {
      const Vec3 r = points_[k] - points_[i];
      sum += r, second += r * r.transpose(), count += 1;
    };
    tree_.forEachWithin(points_[i], smoothing_, [&](std::size_t k, double) { add(k); });
    if (count < double(kFewest)) {
      sum.setZero(), second.setZero(), count = 0;
      std::vector<std::size_t> nearest;
      tree_.nearest(points_[i], kFewest, nearest);
      for (const std::size_t k : nearest) add(k);
    }
    const Eigen::Matrix3d spread = second - sum * sum.transpose() / count;
    pieces_[i].normal =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
  });
}

// +1 where the point's normal points outward, -1 inward, 0 where the flood cannot tell.
int ScanSurface::sideOf(std::size_t i, const ScanFlood& flood) const {
  const auto side = [&](double sign) {
    for (double far = 1; far <= kWalk; far += 0.5) {
      const Vec3 at = points_[i] + sign * far * flood.cell() * pieces_[i].normal;
      if (flood.outside(at)) return 1;
      if (flood.inside(at)) return -1;
    }
    return 0;
  };
  const int ahead = side(1), behind = side(-1);
  return ahead * behind < 0 ? ahead : 0;
}

ScanSurface::Sides ScanSurface::orient(const ScanFlood& flood) {
  std::vector<int> side(points_.size(), 0);
  Sides sides;
  if (!flood.closed()) return sides;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    side[i] = sideOf(i, flood);
    sides.known += side[i] != 0;
  }
  if (2 * sides.known <= points_.size()) return sides;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (side[i] >= 0) continue;
    pieces_[i].normal = -pieces_[i].normal;
    side[i] = 1;
    ++sides.turned;
  }
  sides.turned += orientRest(side);
  return sides;
}

// Undecided points follow the majority of their decided neighbors, round by round.
std::size_t ScanSurface::orientRest(std::vector<int>& side) {
  std::size_t turned = 0;
  std::vector<std::size_t> near, decided;
  do {
    decided.clear();
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (side[i] != 0) continue;
      double vote = 0;
      tree_.nearest(points_[i], kFewest, near);
      for (const std::size_t k : near)
        if (side[k] != 0) vote += pieces_[i].normal.dot(pieces_[k].normal);
      if (std::abs(vote) < 0.5) continue;
      if (vote < 0) pieces_[i].normal = -pieces_[i].normal, ++turned;
      decided.push_back(i);
    }
    for (const std::size_t i : decided) side[i] = 1;
  } while (!decided.empty());
  return turned;
}

void ScanSurface::fit() {
  parallelFor(points_.size(), threads_, [&](std::size_t i, int) { fitPiece(i); });
}

void ScanSurface::fitPiece(std::size_t i) {
  Piece& piece = pieces_[i];
  tangents(piece.normal, piece.t1, piece.t2);
  Eigen::Matrix<double, 6, 6> a = Eigen::Matrix<double, 6, 6>::Zero();
  Vec6 b = Vec6::Zero();
  std::size_t count = 0;
  tree_.forEachWithin(points_[i], smoothing_, [&](std::size_t k, double square) {
    if (pieces_[k].normal.dot(piece.normal) < kSameFace) return;
    const Vec3 r = points_[k] - points_[i];
    const double weight = std::exp(-2 * square / (smoothing_ * smoothing_));
    const Vec6 p = powers(r.dot(piece.t1) / smoothing_, r.dot(piece.t2) / smoothing_);
    a += weight * p * p.transpose();
    b += weight * r.dot(piece.normal) * p;
    ++count;
  });
  const int terms = count >= kForQuadric ? 6 : count >= 5 ? 3 : 0;
  if (terms == 0) return;
  a.diagonal().array() += 1e-6 * a(0, 0);
  const Eigen::VectorXd q = a.topLeftCorner(terms, terms).ldlt().solve(b.head(terms));
  for (int k = 0; k < terms; ++k) piece.q[k] = q[k];
}

ScanSurface::Height ScanSurface::heightOver(std::size_t i, const Vec3& place) const {
  const Piece& p = pieces_[i];
  const Vec3 r = place - points_[i];
  const double side1 = r.dot(p.t1), side2 = r.dot(p.t2);
  // Beyond the fitted neighbors the quadric continues linearly.
  const double u = std::clamp(side1 / smoothing_, -1.0, 1.0);
  const double v = std::clamp(side2 / smoothing_, -1.0, 1.0);
  const double du = p.q[1] + 2 * p.q[3] * u + p.q[4] * v;
  const double dv = p.q[2] + p.q[4] * u + 2 * p.q[5] * v;
  const double q = p.q[0] + p.q[1] * u + p.q[2] * v + p.q[3] * u * u + p.q[4] * u * v +
                   p.q[5] * v * v + du * (side1 / smoothing_ - u) + dv * (side2 / smoothing_ - v);
  const Vec3 out = p.normal - (du * p.t1 + dv * p.t2) / smoothing_;
  const double length = out.norm();
  return {(r.dot(p.normal) - q) / length, out / length, std::hypot(side1, side2)};
}

ScanSurface::Height ScanSurface::heightOf(const Vec3& place) const {
  const std::size_t nearest = tree_.nearest(place);
  const Height first = heightOver(nearest, place);
  const double reach = kBlend * distance_;
  Height mean{0, Vec3::Zero(), first.beside};
  double sum = 0;
  tree_.forEachWithin(points_[nearest], reach, [&](std::size_t k, double) {
    if (pieces_[k].normal.dot(pieces_[nearest].normal) < kSameFace) return;
    const Height h = heightOver(k, place);
    const double weight = std::exp(-2 * h.beside * h.beside / (reach * reach));
    mean.above += weight * h.above;
    mean.normal += weight * h.normal;
    sum += weight;
  });
  if (!(sum > 1e-12)) return first;
  mean.above /= sum;
  mean.normal.normalize();
  return mean;
}

double ScanSurface::distanceTo(const Vec3& place) const {
  return (points_[tree_.nearest(place)] - place).norm();
}

}  // namespace cloudcontact
