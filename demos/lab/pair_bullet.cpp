// Bullet 3.24's own methods on a pair, as its users set them: bodies of about a metre
// (pair_others.h says why), margins a thousandth of a per cent of them (demos/peers.cpp), in float,
// a fresh manifold for the answer, a kept one for the times. Debian's 3.24 has the early-out
// between a convex shape and a triangle that later versions disabled.
//
// primitive: sphere, box, capsule, cylinder, cone, plane. gjk: the hull of the facets' vertices by
// GJK and EPA, which fills holes. gimpact: the facets. hacd: convex parts of the concave bodies,
// the hull of the convex ones. sdf: btSdfCollisionShape, described at its part below.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <numbers>
#include <utility>

#include "lab/pair_others.h"
#include "lab/pair_sdf_bake.h"
#include "mesh_distance.h"
#include "pair_probe.h"
#include "peers.h"

namespace cloudcontact::program::lab {

namespace {

// HACD is given coarser facets: it would merge fine ones for minutes.
constexpr double kHacdFacets = 1.0 / 25;

// The SDF's cells, by the case's size.
constexpr double kCoarseSdf = 1.0 / 8;
constexpr double kFineSdf = 1.0 / 16;

// A half-space has no mesh: with every method it is Bullet's static plane.
PeerShape planeOr(const LabBody& body, const std::function<PeerShape()>& otherwise) {
  return isHalfSpace(body) ? primitiveShape(*body.shape) : otherwise();
}

PeerShape hullOf(const LabBody& body, double tolerance) {
  return planeOr(body, [&] { return hullShape(body.mesh(tolerance)); });
}

LabPair probed(PeerShape a, PeerShape b, Method method) {
  const auto shapes = std::make_shared<std::pair<PeerShape, PeerShape>>(std::move(a), std::move(b));
  const auto probeAt = [shapes, method](const Pose& pose) {
    return std::make_unique<PairProbe>(*shapes->first.shape, *shapes->second.shape, pose, Motion{},
                                       method, CloudContactSettings{});
  };
  return {[probeAt](const Pose& pose) {
            std::vector<LabPoint> points;
            for (const ProbedPoint& p : probeAt(pose)->points())
              points.push_back({p.position, p.normal, p.depth, 0});
            return touching(points);
          },
          [probeAt](const Pose& pose, int repeat, double jitter) {
            return probeAt(pose)->microseconds(repeat, jitter);
          }};
}

// A cone is the one primitive that Bullet puts its margin of 4 cm around rather than inside of.
constexpr double kConeMargin = 1e-5;

PeerShape ownShape(const AnalyticShape& shape) {
  PeerShape made = primitiveShape(shape);
  if (const auto* cone = std::get_if<ConeShape>(&shape))
    made.shape->setMargin(btScalar(std::max(kConeMargin, cone->margin)));
  return made;
}

LabPair primitivePair(const LabBody& a, const LabBody& b, double) {
  return probed(ownShape(primitiveOf(a)), ownShape(primitiveOf(b)), Method::Primitive);
}

LabPair hullPair(const LabBody& a, const LabBody& b, double tolerance) {
  return probed(hullOf(a, tolerance), hullOf(b, tolerance), Method::Gjk);
}

LabPair gimpactPair(const LabBody& a, const LabBody& b, double tolerance) {
  const auto shape = [&](const LabBody& body) {
    return planeOr(body, [&] { return gimpactShape(body.mesh(tolerance)); });
  };
  return probed(shape(a), shape(b), Method::Gimpact);
}

// Convex parts made before, since a body comes in many poses and takes seconds, or
// minutes where it has thousands of triangles.
class PartsMade {
 public:
  PeerShape of(const Mesh& mesh) {
    const std::lock_guard lock(mutex_);
    for (const auto& [known, shape] : made_)
      if (known.vertices == mesh.vertices && known.triangles == mesh.triangles) return shape;
    made_.emplace_back(mesh, convexPartsShape(mesh));
    return made_.back().second;
  }

 private:
  std::mutex mutex_;
  std::vector<std::pair<Mesh, PeerShape>> made_;
};

LabMethod hacdMethod() {
  const auto made = std::make_shared<PartsMade>();
  return {"hacd", "parts of facets " + fraction(kHacdFacets), kHacdFacets,
          [made](const LabBody& a, const LabBody& b, double tolerance) {
            const auto isPart = [](const LabBody& body) {
              return body.convex || isHalfSpace(body);
            };
            if (isPart(a) && isPart(b))
              throw CannotDo("both bodies are convex: gjk's hulls already");
            const auto shape = [&](const LabBody& body) {
              return isPart(body) ? hullOf(body, tolerance) : made->of(body.mesh(tolerance));
            };
            return probed(shape(a), shape(b), Method::Hacd);
          }};
}

// btSdfCollisionShape. Its one algorithm (btConvexConcaveCollisionAlgorithm) looks the vertices of
// a polyhedral convex shape up in the field, or a sphere's centre; capsules, cylinders and cones
// are skipped without a word, and so is anything concave, another SDF among it. Vertices alone:
// where the SDF's edge or tip dips into a face nothing is found. Hence one body must be a sphere
// or convex, and comes as btSphereShape or as the hull of facets within a tenth of a cell. The
// other is baked, by its formula where there is one, else by its distance to facets as fine; of two
// that could be, the larger, so that the smaller's corners lie in its field.
constexpr double kFacetsOfCell = 0.1;

bool isSphere(const LabBody& body) {
  return body.shape && std::holds_alternative<SphereShape>(*body.shape);
}

// The distance of a half-space is linear, which cubic cells keep exactly: few and large ones.
PeerShape planeSdf(const HalfSpace& plane, double reach) {
  const Vec3 half = Vec3::Constant(10 * reach), foot = plane.offset * plane.normal;
  return bakedSdfShape([&](const Vec3& p) { return -shapeAt(plane, p).depth; },
                       Eigen::AlignedBox3d(foot - half, foot + half), 10 * reach);
}

// `pad`: how far from the surface the other's points are still looked up.
PeerShape sdfOf(const LabBody& body, double cell, double pad) {
  const Mesh mesh = body.mesh(kFacetsOfCell * cell);
  const MeshDistance byMesh(mesh);
  const Vec3 margin = Vec3::Constant(cell + pad);
  const Eigen::AlignedBox3d domain(byMesh.bounds().min() - margin, byMesh.bounds().max() + margin);
  int hint = 0;
  const auto distance = [&](const Vec3& p) {
    return body.shape ? -shapeAt(*body.shape, p).depth
                      : -byMesh.depth(p, std::numeric_limits<double>::infinity(), &hint);
  };
  return bakedSdfShape(distance, domain, cell);
}

LabPair sdfPair(const LabBody& a, const LabBody& b, double cell) {
  const auto askable = [](const LabBody& body) { return body.convex && !isHalfSpace(body); };
  if (!askable(a) && !askable(b))
    throw CannotDo("btSdfCollisionShape meets spheres and convex polyhedra only");
  const double tolerance = kFacetsOfCell * cell;
  const bool bakeA = !askable(a) || (askable(b) && reachOf(a, tolerance) >= reachOf(b, tolerance));
  const LabBody &field = bakeA ? a : b, &other = bakeA ? b : a;
  const double reach = reachOf(other, tolerance);
  PeerShape sdf = isHalfSpace(field) ? planeSdf(std::get<HalfSpace>(*field.shape), reach)
                                     : sdfOf(field, cell, isSphere(other) ? reach : 0);
  PeerShape convex = isSphere(other) ? primitiveShape(*other.shape) : hullOf(other, tolerance);
  if (!bakeA) std::swap(sdf, convex);
  return probed(std::move(sdf), std::move(convex), Method::Sdf);
}

// The directions of jitter, the same on every run: evenly over the sphere, never two alike.
Vec3 jitterDirection(int k) {
  const double height = std::fmod(k * std::numbers::phi, 1.0) * 2 - 1;
  const double angle = 2.399963229728653 * k, radius = std::sqrt(1 - height * height);
  return {radius * std::cos(angle), radius * std::sin(angle), height};
}

}  // namespace

std::vector<double> timedCalls(const Pose& b, int repeat, double jitter,
                               const std::function<void(const Pose&)>& call) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> times;
  for (int k = -1; k < repeat; ++k) {
    Pose moved = b;
    moved.position += jitter * jitterDirection(k + 1);
    const auto start = Clock::now();
    call(moved);
    const std::chrono::duration<double, std::micro> time = Clock::now() - start;
    if (k >= 0) times.push_back(time.count());
  }
  return times;
}

std::vector<LabMethod> bulletMethods() {
  const std::string coarse = "facets " + fraction(kCoarseFacets);
  const std::string fine = "facets " + fraction(kFineFacets);
  const std::vector<LabMethod> methods = {
      {"primitive", "Bullet's own shapes", 0, primitivePair},
      {"gjk", "hull, " + coarse, kCoarseFacets, hullPair},
      {"gjk", "hull, " + fine, kFineFacets, hullPair},
      {"gimpact", coarse, kCoarseFacets, gimpactPair},
      {"gimpact", fine, kFineFacets, gimpactPair},
      hacdMethod(),
      {"sdf", "cells " + fraction(kCoarseSdf), kCoarseSdf, sdfPair},
      {"sdf", "cells " + fraction(kFineSdf), kFineSdf, sdfPair}};
  std::vector<LabMethod> all;
  for (const LabMethod& method : methods) all.push_back(atMetreScale(method));
  return all;
}

}  // namespace cloudcontact::program::lab
