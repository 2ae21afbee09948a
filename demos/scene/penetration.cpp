// Closed-form depths of primitives, and the search for the deepest probe.
#include "scene/penetration.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace cloudcontact::program {
namespace {

constexpr int kSurfaceProbes = 4000;  // per solid, beside its vertices
constexpr int kAxisProbes = 129;      // along a capsule's axis
constexpr std::size_t kBlockProbes = 32;

// Depth in a shape. For each dimension `outside` is the distance of the point beyond a pair of
// sides, negative inside.
template <class Vector>
double depthFromSides(const Vector& outside) {
  const double beyond = outside.cwiseMax(0).norm();
  return beyond > 0 ? -beyond : -outside.maxCoeff();
}

// In the half-plane of radius and height, in which a cone is the triangle below its slant line.
double depthInCone(const SceneCone& cone, const Eigen::Vector2d& p) {
  using Eigen::Vector2d;
  const Vector2d tip(0, cone.length / 2), rim(cone.radius, -cone.length / 2);
  const Vector2d slant = rim - tip, outward = Vector2d(cone.length, cone.radius).normalized();
  const double overSlant = outward.dot(p - tip), underBase = rim.y() - p.y();
  if (overSlant <= 0 && underBase <= 0) return -std::max(overSlant, underBase);
  const double along = std::clamp(slant.dot(p - tip) / slant.squaredNorm(), 0.0, 1.0);
  const Vector2d onBase(std::min(p.x(), cone.radius), rim.y());
  return -std::min((p - tip - along * slant).norm(), (p - onBase).norm());
}

struct DepthVisitor {
  const Vec3& p;
  double reach;

  double operator()(const SceneBox& box) const {
    return depthFromSides(Vec3(p.cwiseAbs() - box.size / 2));
  }
  double operator()(const SceneSphere& sphere) const { return sphere.radius - p.norm(); }
  double operator()(const SceneCylinder& c) const {
    return depthFromSides(
        Eigen::Vector2d(p.head<2>().norm() - c.radius, std::abs(p.z()) - c.length / 2));
  }
  double operator()(const SceneCapsule& c) const {
    const double z = std::clamp(p.z(), -c.length / 2, c.length / 2);
    return c.radius - (p - Vec3(0, 0, z)).norm();
  }
  double operator()(const SceneCone& c) const {
    return depthInCone(c, Eigen::Vector2d(p.head<2>().norm(), p.z()));
  }
  double operator()(const ScenePlane& plane) const { return -plane.normal.dot(p); }
  double operator()(const std::shared_ptr<const MeshDistance>& mesh) const {
    return mesh->depth(p, reach);
  }
};

struct ProbeVisitor {
  const Mesh* mesh;

  std::vector<Probe> operator()(const SceneSphere& sphere) const {
    return {{Vec3::Zero(), sphere.radius}};
  }
  std::vector<Probe> operator()(const SceneCapsule& c) const {
    std::vector<Probe> probes;
    for (int i = 0; i < kAxisProbes; ++i)
      probes.push_back({Vec3(0, 0, c.length * (i / (kAxisProbes - 1.0) - 0.5)), c.radius});
    return probes;
  }
  std::vector<Probe> operator()(const ScenePlane&) const { return {}; }
  template <class Other>
  std::vector<Probe> operator()(const Other&) const {
    if (!mesh) throw std::invalid_argument("penetration: a mesh is needed for the probes");
    std::vector<Probe> probes;
    for (const Vec3& p : surfacePoints(*mesh, kSurfaceProbes)) probes.push_back({p, 0});
    return probes;
  }
};

MeasuredSolid solidOf(const SceneGeometry& geometry, const Mesh* mesh) {
  return std::visit(
      [&](const auto& shape) -> MeasuredSolid {
        if constexpr (std::is_same_v<std::decay_t<decltype(shape)>, SceneMesh>) {
          if (!mesh) throw std::invalid_argument("penetration: a mesh geometry without its mesh");
          return std::make_shared<const MeshDistance>(*mesh);
        } else {
          return shape;
        }
      },
      geometry);
}

// Splits probes [first, first + count) at the middle of their longest side until blocks are small.
void split(std::vector<Probe>& probes, std::size_t first, std::size_t count,
           std::vector<ProbeBlock>& blocks) {
  const auto begin = probes.begin() + static_cast<std::ptrdiff_t>(first);
  const auto end = begin + static_cast<std::ptrdiff_t>(count);
  Eigen::AlignedBox3d box;
  std::for_each(begin, end, [&](const Probe& p) { box.extend(p.position); });
  if (count <= kBlockProbes) {
    ProbeBlock block{box.center(), 0, first, count};
    std::for_each(begin, end, [&](const Probe& p) {
      block.radius = std::max(block.radius, (p.position - block.center).norm() + p.radius);
    });
    blocks.push_back(block);
    return;
  }
  int axis = 0;
  box.sizes().maxCoeff(&axis);
  const std::size_t half = count / 2;
  std::nth_element(
      begin, begin + static_cast<std::ptrdiff_t>(half), end,
      [axis](const Probe& a, const Probe& b) { return a.position[axis] < b.position[axis]; });
  split(probes, first, half, blocks);
  split(probes, first + half, count - half, blocks);
}

// Whether a ball about a place in the solid's frame may hold a probe deeper than `known`.
bool mayHoldDeeper(const MeasuredSolid& solid, const Vec3& center, double radius, double known) {
  // A depth in closed form changes by no more than the way.
  if (const auto* mesh = std::get_if<std::shared_ptr<const MeshDistance>>(&solid))
    return (*mesh)->bounds().squaredExteriorDistance(center) <= radius * radius;
  return depthIn(solid, center, radius) + radius > known;
}

// Largest depth of the probes of `a` in the solid of `b`, if above the one known already.
double deepest(const Probed& a, const Pose& aToWorld, const Probed& b, const Pose& bToWorld,
               double known) {
  const Pose aToB = bToWorld.inverse() * aToWorld;
  const Eigen::Matrix3d turn = aToB.orientation.toRotationMatrix();
  const auto* mesh = std::get_if<std::shared_ptr<const MeshDistance>>(&b.solid);
  int hint = 0;
  for (const ProbeBlock& block : a.blocks) {
    if (!mayHoldDeeper(b.solid, turn * block.center + aToB.position, block.radius, known)) continue;
    for (std::size_t i = block.first; i < block.first + block.count; ++i) {
      const Probe& probe = a.probes[i];
      const Vec3 p = turn * probe.position + aToB.position;
      const double depth =
          (mesh ? (*mesh)->depth(p, probe.radius, &hint) : depthIn(b.solid, p, probe.radius)) +
          probe.radius;
      if (depth <= known) continue;
      // Meshes may be folded, so the winding number must confirm a new maximum. It applies only to
      // points that are themselves inside.
      if (mesh && depth > probe.radius && (*mesh)->winding(p) < 0.5) continue;
      known = depth;
    }
  }
  return known;
}

}  // namespace

double depthIn(const MeasuredSolid& solid, const Vec3& point, double reach) {
  return std::visit(DepthVisitor{point, reach}, solid);
}

std::shared_ptr<const Probed> probed(const SceneGeometry& geometry, const Mesh* mesh) {
  auto out = std::make_shared<Probed>();
  out->solid = solidOf(geometry, mesh);
  out->probes = std::visit(ProbeVisitor{mesh}, geometry);
  if (!out->probes.empty()) split(out->probes, 0, out->probes.size(), out->blocks);
  return out;
}

double penetration(const MeasuredBody& a, const Pose& poseA, const MeasuredBody& b,
                   const Pose& poseB) {
  double known = 0;
  for (const auto& partA : a.parts)
    for (const auto& partB : b.parts) {
      const Pose toWorldA = poseA * partA.pose, toWorldB = poseB * partB.pose;
      known = deepest(*partA.what, toWorldA, *partB.what, toWorldB, known);
      known = deepest(*partB.what, toWorldB, *partA.what, toWorldA, known);
    }
  return known;
}

std::size_t probeCount(const MeasuredBody& body) {
  std::size_t count = 0;
  for (const auto& part : body.parts) count += part.what->probes.size();
  return count;
}

}  // namespace cloudcontact::program
