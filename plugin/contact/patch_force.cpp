// Direction, torque and points of a patch.
//
// Force. The sum over a body's own samples of area times depth along their own normals is the
// gradient of the overlap's energy (FORCE.md, "P"). Where the law's magnitude does not grow with
// area (the paper's, one spring a pair) the energy knows no edge either, and the push of walls that
// run along the other body's face is taken out, as far as both bodies agree on it; the more
// coherent body (a face against an edge) decides the direction ("CW").
//
// Points. For a patch of area centre x, covariance C and mean depth 1, four points at
// x0 + root(C') (+-1, +-1) with depths 1 + g.xi have force 1 and centre of pressure x0 + C' g,
// for any C' and g; so x0 = cop - C' g makes the wrench exact, whatever is chosen for the rest:
//   g  = C^-1 (cop - x), the slope of the pressure, less where a point would pull;
//   C' = C where the bodies fit each other, shrunk to nothing where relative curvature alone
//        bounds the patch: there points apart from the centre would brake rolling, as an
//        implicit step moves the pressure ahead by v h (a ball lost 20 % in 3 m).
// The root is symmetric, so that the points do not turn with the eigenvectors of a round patch.
#include "patch_force.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

using M2 = Eigen::Matrix2d;
using V2 = Eigen::Vector2d;
using Basis = Eigen::Matrix<double, 3, 2>;

// Below this lack of coherence the bodies decide alike: noise of the normals is 0.001.
constexpr double kCoherenceNoise = 0.003;
// A shape's own normals have none but rounding: where they all agree the shape decides, even
// against a cloud's rim of which only the side is wet (a peg on its rim was pushed 11 deg aside).
constexpr double kFormulaNoise = 1e-6;
constexpr double kLeastWeight = 0.05;  // of a point, so that none pulls
// Patches narrower than this [voxels] are too small for their normals' gradient to be told from
// noise. Points that do not lean with their flank brake a thread through the pair's damping: on a
// M16 thread their normals are 3.3 deg off the way of the screw at 8, 1.3 deg at 1.
constexpr double kLeanVoxels = 1;
// What rolls bounds its patch by curvature alone. Its flatness is then nothing but noise, 0.06
// under a ball of 20 voxels that sags by 0.1, and points that it holds apart brake: less than this
// counts for nothing, a little more for itself. Without it balls and cylinders lost 1.4-3.3 % of
// their speed in 3 m, with it less than 1 %. Faces must keep what they have: scaled down from 1, a
// box over a table's edge tipped 0.2 voxel earlier. It costs: a peg that rattles at 60 steps a
// second was quieted by that braking, and with any value from 0.07 to 0.15 jams in 2-4 of 5 holes
// instead of 1; which ones is chance. From 240 steps on all of them go in with this one, but not
// with 0.1 or 0.12, by as little.
constexpr double kRound = 0.09, kRoundAgain = 5;
constexpr double kMostSpin = 0.3;  // [rad] a point's normal leans for the patch's spin

Vec3 unit(const Vec3& v) {
  const double length = v.norm();
  return length > 0 ? Vec3(v / length) : Vec3::Zero();
}

// What both bodies' walls push alike across the patch's normal.
Vec3 sharedWall(const Vec3& pushA, const Vec3& pushB, const Vec3& wallA, const Vec3& wallB) {
  Vec3 shared = Vec3::Zero();
  for (int round = 0; round < 3; ++round) {
    const Vec3 n = unit(pushA + pushB - 2 * shared);
    const Vec3 a = wallA - n * n.dot(wallA), b = wallB - n * n.dot(wallB);
    if (a.dot(b) <= 0) return Vec3::Zero();
    shared = unit(a + b) * std::min(a.norm(), b.norm());
  }
  return shared;
}

template <typename Function>
M2 ofEigenvalues(const M2& symmetric, Function f) {
  Eigen::SelfAdjointEigenSolver<M2> solver;
  solver.computeDirect(symmetric);
  const V2 values(f(solver.eigenvalues()[0]), f(solver.eigenvalues()[1]));
  return solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose();
}

Basis tangents(const Vec3& n) {
  int axis = 0;
  n.cwiseAbs().minCoeff(&axis);
  Basis t;
  t.col(0) = n.cross(Vec3::Unit(axis)).normalized();
  t.col(1) = n.cross(t.col(0));
  return t;
}

// The patch in its own plane.
struct Flat {
  Vec3 n;
  Basis t;
  M2 spread;   // C
  M2 inverse;  // C^-1, regularised
  M2 turn[2];  // of each body's normals, with the place: curvature times C [m]
};

Flat flatten(const Sums& patch, const Vec3& n) {
  Flat f;
  f.n = n;
  f.t = tangents(n);
  const Vec3 x = patch.first / patch.area;
  f.spread = f.t.transpose() * (patch.second / patch.area - x * x.transpose()) * f.t;
  // A patch of one sample has no spread: a thousandth of its area stands in.
  const double floor = 1e-3 * (patch.area + f.spread.trace());
  f.inverse = (f.spread + floor * M2::Identity()).inverse();
  double cosine = 0;
  for (int s = 0; s < 2; ++s) {
    const Vec3 mean = patch.normal[s] / patch.area;
    f.turn[s] = f.t.transpose() * (patch.normalBy[s] / patch.area - mean * x.transpose()) * f.t;
    cosine += 0.5 * std::abs(mean.dot(n));
  }
  for (M2& turn : f.turn) turn /= std::max(cosine, 0.3);
  return f;
}

// Where points may lie, C', and how the common normal turns over them [1/m].
struct Extent {
  M2 kept, lean;
};

Extent extentOf(const Flat& f, double depth, double voxel) {
  Extent e;
  const M2 gap = (f.turn[0] + f.turn[1]) / std::max(depth, 1e-30);
  const M2 flatness = ofEigenvalues(M2::Identity() - 0.5 * (gap + gap.transpose()), [](double v) {
    return std::clamp(std::min(v, kRoundAgain * (v - kRound)), 0.0, 1.0);
  });
  const M2 root = ofEigenvalues(f.spread, [](double v) { return std::sqrt(std::max(v, 0.0)); });
  e.kept = root * flatness * root;
  const double noise = kLeanVoxels * voxel * kLeanVoxels * voxel;
  e.lean = 0.5 * (f.turn[0] - f.turn[1]) * (f.spread + noise * M2::Identity()).inverse();
  return e;
}

// Half of curvature times the places' spread, both summed over directions. A sample lies where its
// own surface has its mean over it, and counts by its middle alone: its own curvature over its own
// width (variance about a twelfth of its area each way) is missing there. And normals that lean
// shorten the way across: by the cosines, exact to second order for a ball on a face.
double fallOf(const Sums& patch, const Vec3& n, double lean, bool oneSided, Side sampled) {
  const Flat f = flatten(patch, n);
  const M2 own = oneSided ? f.turn[sampled] : M2(0.5 * (f.turn[0] + f.turn[1]));
  const double within = patch.width / patch.area / 12 * (own * f.inverse).trace();
  const double bent = (patch.opening - patch.apart.dot(patch.place) / patch.facing) / patch.facing;
  return 0.5 * (bent / std::max(lean, 0.5) + within);
}

// A body without samples of its own in the patch, as a flank has none where a tooth's tip just
// touches it, is known by the normals that the other's samples found there (the paper's own base
// vectors). Gives the side that push; returns its incoherence.
double lookedUp(const Sums& patch, int s, Vec3* push) {
  const double found = patch.normal[s].norm();
  if (!(found > 0)) return 1e3;  // the other decides
  const double sign = s == kA ? 1.0 : -1.0;
  push[s] = sign * push[1 - s].norm() / found * patch.normal[s];
  return std::max(0.0, 1 - found / patch.area) + kCoherenceNoise;
}

}  // namespace

PatchForce forceOf(const Sums& patch, bool foundation, bool oneSided, Side sampled) {
  PatchForce out;
  out.center = patch.origin + (patch.area > 0 ? Vec3(patch.first / patch.area) : Vec3::Zero());
  const Vec3 arm = patch.origin - out.center;
  Vec3 push[2], moment[2], wall[2];
  for (int s = 0; s < 2; ++s) {
    const double sign = s == kA ? 1.0 : -1.0;  // A's outward normals push B, B's own push it back
    push[s] = sign * patch.side[s].push;
    moment[s] = sign * (patch.side[s].moment + arm.cross(patch.side[s].push));
    wall[s] = sign * patch.side[s].wall;
  }
  Vec3 force = 0.5 * (push[0] + push[1]), torque = 0.5 * (moment[0] + moment[1]);
  if (oneSided) {
    force = push[sampled];
    torque = moment[sampled];
  }
  out.force = force;
  out.torque = torque;
  if (foundation || force.norm() == 0) return out;

  const Vec3 shared = sharedWall(push[0], push[1], wall[0], wall[1]);
  double incoherence[2];
  for (int s = 0; s < 2; ++s) {
    push[s] -= shared;
    const double size = std::max(patch.side[s].size, 1e-300);
    const bool formula = oneSided && s != sampled;
    incoherence[s] =
        std::max(0.0, 1.0 - push[s].norm() / size) + (formula ? kFormulaNoise : kCoherenceNoise);
    if (patch.side[s].size == 0) incoherence[s] = lookedUp(patch, s, push);
  }
  out.trustA = incoherence[1] / (incoherence[0] + incoherence[1]);
  const Vec3 n = unit(out.trustA * push[0] + (1 - out.trustA) * push[1]);
  if (n.squaredNorm() == 0) return out;
  const double size = 0.5 * (push[0].norm() + push[1].norm());
  // The same line of action: through the old centre of pressure, with the old spin.
  const Vec3 old = unit(force);
  const Vec3 pressure = old.cross(torque) / force.norm();
  out.force = size * n;
  out.torque = pressure.cross(out.force) + (old.dot(torque) * size / force.norm()) * n;
  if (!(patch.facing > 0)) return out;
  out.lean = patch.normal[0].norm() * patch.normal[1].norm() / (patch.area * patch.area);
  out.fall = fallOf(patch, n, out.lean, oneSided, sampled);
  return out;
}

PatchPoints pointsOf(const Sums& patch, const PatchForce& force, double voxel) {
  PatchPoints out;
  const Flat f = flatten(patch, unit(force.force));
  const Extent e = extentOf(f, patch.facing / patch.area, voxel);
  const double size = force.force.norm();
  const Vec3 arm = f.n.cross(force.torque) / size;  // centre of pressure less area centre
  const V2 cop = f.t.transpose() * arm;
  V2 slope = f.inverse * cop;
  const M2 root = ofEigenvalues(e.kept, [](double v) { return std::sqrt(std::max(v, 0.0)); });
  const V2 corner[4] = {V2(1, 1), V2(-1, 1), V2(-1, -1), V2(1, -1)};
  double least = 0;
  for (const V2& c : corner) least = std::min(least, slope.dot(root * c));
  if (least < kLeastWeight - 1) slope *= (1 - kLeastWeight) / -least;
  const V2 middle = cop - e.kept * slope;
  double spin = f.n.dot(force.torque) / size, polar = 0;
  V2 at[4];
  for (int i = 0; i < 4; ++i) {
    at[i] = middle + root * corner[i] - cop;
    out.weight[i] = 1 + slope.dot(root * corner[i]);
    const V2 turned = e.lean * at[i];
    spin -= 0.25 * out.weight[i] * (at[i].x() * turned.y() - at[i].y() * turned.x());
    polar += 0.25 * out.weight[i] * at[i].squaredNorm();
  }
  const double noise = kLeanVoxels * voxel * kLeanVoxels * voxel;
  const double most = kMostSpin / std::sqrt(std::max(polar, 1e-300));
  const double omega = polar > 0 ? std::clamp(spin / (polar + noise), -most, most) : 0.0;
  double kept = 0;
  for (int i = 0; i < 4; ++i) {
    const V2 turned = e.lean * at[i] + omega * V2(-at[i].y(), at[i].x());
    out.normal[i] = (f.n + f.t * turned).normalized();
    out.position[i] = force.center + arm + f.t * at[i];
    kept += 0.25 * out.weight[i] * out.normal[i].dot(f.n);
  }
  for (double& w : out.weight) w /= kept;
  return out;
}

}  // namespace cloudcontact
