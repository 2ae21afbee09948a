// Bullet 3.24's own methods on a pair, as its users set them: bodies of about a metre
// (pair_others.h says why), margins a thousandth of a per cent of them (demos/scene/bullet_methods.cpp), in float,
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
#include "scene/mesh_distance.h"
#include "scene/pair_probe.h"
#include "scene/bullet_methods.h"

namespace cloudcontact::program::lab {

namespace {

// HACD is given coarser facets: it would merge fine ones for minutes.
constexpr double kHacdFacets = 1.0 / 25;

// The SDF's cells, by the case's size.
constexpr double kCoarseSdf = 1.0 / 8;
constexpr double kFineSdf = 1.0 / 16;

// As demos/scene/bullet_methods.cpp sets it.
constexpr const char* kMargin =
    "margin a thousandth of a per cent of the diagonal (Bullet's 4 cm would hide errors); in float";

// A half-space has no mesh: with every method it is Bullet's static plane.
BulletShape planeOr(const LabBody& body, const std::function<BulletShape()>& otherwise) {
  return isHalfSpace(body) ? primitiveShape(*body.shape) : otherwise();
}

BulletShape hullOf(const LabBody& body, double tolerance) {
  return planeOr(body, [&] { return hullShape(body.mesh(tolerance)); });
}

LabPair probed(const BulletShape& a, const BulletShape& b, Method method) {
  const auto probeAt = [a, b, method](const Pose& pose) {
    return std::make_unique<PairProbe>(*a.shape, *b.shape, pose, Motion{}, method,
                                       CloudContactSettings{});
  };
  return {[probeAt](const Pose& pose) {
            std::vector<LabPoint> points;
            for (const ProbedPoint& p : probeAt(pose)->points())
              points.push_back({p.position, p.normal, p.depth, 0});
            return touching(points);
          },
          [probeAt](const Pose& pose, int repeat, double jitter) {
            return probeAt(pose)->microseconds(repeat, jitter);
          },
          {},
          [a, b, method] { return probed(b, a, method); }};
}

LabPair primitivePair(const LabBody& a, const LabBody& b, double) {
  return probed(primitiveShape(primitiveOf(a)), primitiveShape(primitiveOf(b)), Method::Primitive);
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
  BulletShape of(const Mesh& mesh) {
    const std::lock_guard lock(mutex_);
    for (const auto& [known, shape] : made_)
      if (known.vertices == mesh.vertices && known.triangles == mesh.triangles) return shape;
    made_.emplace_back(mesh, convexPartsShape(convexParts(mesh)));
    return made_.back().second;
  }

 private:
  std::mutex mutex_;
  std::vector<std::pair<Mesh, BulletShape>> made_;
};

LabMethod hacdMethod() {
  const auto made = std::make_shared<PartsMade>();
  LabMethod method = {
      "hacd", "parts of facets " + fraction(kHacdFacets), kHacdFacets,
      [made](const LabBody& a, const LabBody& b, double tolerance) {
        const auto isPart = [](const LabBody& body) { return body.convex || isHalfSpace(body); };
        if (isPart(a) && isPart(b)) throw CannotDo("both bodies are convex: gjk's hulls already");
        const auto shape = [&](const LabBody& body) {
          return isPart(body) ? hullOf(body, tolerance) : made->of(body.mesh(tolerance));
        };
        return probed(shape(a), shape(b), Method::Hacd);
      }};
  method.told =
      "concave bodies cut into convex parts by HACD (concavity a hundredth of the "
      "diagonal, 64 vertices a part) from " +
      facetsWithin(kHacdFacets) + ", coarsened to 2,000 triangles; convex bodies by their hull; " +
      kMargin;
  method.facets = true;
  return method;
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
  return body.shape && std::holds_alternative<Sphere>(*body.shape);
}

// The distance of a half-space is linear, which cubic cells keep exactly: few and large ones.
BulletShape planeSdf(const HalfSpace& plane, double reach) {
  const Vec3 half = Vec3::Constant(10 * reach), foot = plane.offset * plane.normal;
  return bakedSdfShape([&](const Vec3& p) { return -solidAt(plane, p).depth; },
                       Eigen::AlignedBox3d(foot - half, foot + half), 10 * reach);
}

// `pad`: how far from the surface the other's points are still looked up.
BulletShape sdfOf(const LabBody& body, double cell, double pad) {
  const Mesh mesh = body.mesh(kFacetsOfCell * cell);
  const MeshDistance byMesh(mesh);
  const Vec3 margin = Vec3::Constant(cell + pad);
  const Eigen::AlignedBox3d domain(byMesh.bounds().min() - margin, byMesh.bounds().max() + margin);
  int hint = 0;
  const auto distance = [&](const Vec3& p) {
    return body.shape ? -solidAt(*body.shape, p).depth
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
  BulletShape sdf = isHalfSpace(field) ? planeSdf(std::get<HalfSpace>(*field.shape), reach)
                                     : sdfOf(field, cell, isSphere(other) ? reach : 0);
  BulletShape convex = isSphere(other) ? primitiveShape(*other.shape) : hullOf(other, tolerance);
  if (!bakeA) std::swap(sdf, convex);
  return probed(sdf, convex, Method::Sdf);
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
  std::vector<LabMethod> methods = {{"primitive", "Bullet's own shapes", 0, primitivePair,
                                     "sphere, box, capsule, cylinder, cone, plane with Bullet's "
                                     "default margins inside them; a cone's, which Bullet puts "
                                     "around it, " +
                                         std::string(kMargin)}};
  for (const double facets : kFacetLadder)
    methods.push_back({"gjk", "hull, facets " + fraction(facets), facets, hullPair,
                       "GJK and EPA on the convex hull of " + facetsWithin(facets) +
                           ", Bullet's default tolerances, " + kMargin,
                       true});
  for (const double facets : kFacetLadder)
    methods.push_back({"gimpact", "facets " + fraction(facets), facets, gimpactPair,
                       "btGImpactMeshShape on " + facetsWithin(facets) + ", " + kMargin, true});
  methods.push_back(hacdMethod());
  for (const double cells : {kCoarseSdf, kFineSdf})
    methods.push_back({"sdf", "cells " + fraction(cells), cells, sdfPair,
                       "btSdfCollisionShape, cubic cells of " + fraction(cells) +
                           " of the size, baked from the formula or from facets within a tenth of "
                           "a cell; the other body a sphere or the hull of such facets, " +
                           kMargin});
  std::vector<LabMethod> all;
  for (const LabMethod& method : methods) all.push_back(atMetreScale(method));
  return all;
}

}  // namespace cloudcontact::program::lab
