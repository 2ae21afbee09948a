// Bullet 3.24's own methods, set as its users would: bodies of about 1 m (peer_pairs.h explains
// why), margins of 1e-5 of their diagonal (scene/bullet_methods.cpp), in float. Answers use a fresh
// manifold, times a persistent one. Debian's 3.24 has the early-out between a convex shape and a
// triangle that later versions disabled.
//
// primitive: sphere, box, capsule, cylinder, cone, plane. gjk: GJK and EPA on the convex hull of
// the facets, which fills holes. gimpact: the facets. hacd: convex parts of concave bodies, hulls
// of convex ones. sdf: btSdfCollisionShape, see below.
#include <BulletCollision/CollisionShapes/btSdfCollisionShape.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "lab/peer_pairs.h"
#include "scene/bullet_methods.h"
#include "scene/mesh_distance.h"
#include "scene/pair_probe.h"

namespace cloudcontact::program::lab {

namespace {

// HACD gets coarser facets: finer ones take it minutes.
constexpr double kHacdFacets = 1.0 / 25;

// The SDF's cell / size of the case.
constexpr double kCoarseSdf = 1.0 / 8;
constexpr double kFineSdf = 1.0 / 16;
constexpr int kMaxSdfCells = 64;  // along an axis

// scene/bullet_methods.cpp sets it.
constexpr const char* kMargin =
    "margin 0.001 % of the diagonal (Bullet's 4 cm would hide errors), in float";

// A half-space has no mesh: every method takes it as Bullet's static plane.
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

// Caches convex parts: decomposing a body takes seconds, or minutes with thousands of triangles.
class PartsCache {
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
  const auto made = std::make_shared<PartsCache>();
  LabMethod method = {
      "hacd", "parts of facets " + fraction(kHacdFacets), kHacdFacets,
      [made](const LabBody& a, const LabBody& b, double tolerance) {
        const auto isPart = [](const LabBody& body) { return body.convex || isHalfSpace(body); };
        if (isPart(a) && isPart(b)) throw CannotDo("both bodies are convex: equal to gjk");
        const auto shape = [&](const LabBody& body) {
          return isPart(body) ? hullOf(body, tolerance) : made->of(body.mesh(tolerance));
        };
        return probed(shape(a), shape(b), Method::Hacd);
      }};
  method.description =
      "concave bodies as convex parts by HACD (concavity 1 % of the diagonal, 64 vertices per "
      "part) from " +
      facetsWithin(kHacdFacets) + ", coarsened to 2,000 triangles; convex bodies as their hulls; " +
      kMargin;
  method.facets = true;
  return method;
}

// btSdfCollisionShape. Its only algorithm (btConvexConcaveCollisionAlgorithm) looks up the vertices
// of a convex polyhedron in the field, or a sphere's center. Capsules, cylinders, cones and all
// concave shapes, SDFs included, are skipped silently. Where an edge or tip of the SDF's body dips
// into a face, no vertex is inside and nothing is found. So one body must be a sphere or convex; it
// is a btSphereShape, or the hull of facets within a tenth of a cell. The other is baked, from its
// formula or from its distance to facets as fine. Of two that could be baked, the larger is.
constexpr double kFacetsOfCell = 0.1;

// Bullet reads the format of the library Discregrid (.cdf files; btMiniSDF::load): the domain, the
// number of cells per axis, then for each field (here one) the node values, 32 node numbers per
// cell, and the cell at each grid index. A cell's 32 nodes are its corners and two on each edge, at
// one and two thirds: cubic interpolation without inner nodes. Cells share the nodes of common
// edges, so a node is identified by its index on the lattice of thirds of cells.
using Place = std::array<int, 3>;  // index on the lattice of thirds

// The nodes of a cell, in thirds, in the order of btMiniSDF::shape_function_: corners, then edges
// along x, y and z; within an axis the index along the next axis (cyclic) changes slowest.
std::array<Place, 32> nodePlaces() {
  std::array<Place, 32> places{};
  std::size_t k = 0;
  for (int corner = 0; corner < 8; ++corner)
    places[k++] = {corner & 1 ? 3 : 0, corner & 2 ? 3 : 0, corner & 4 ? 3 : 0};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (int slow = 0; slow < 2; ++slow)
      for (int fast = 0; fast < 2; ++fast)
        for (int third = 1; third <= 2; ++third) {
          Place& place = places[k++];
          place[axis] = third;
          place[(axis + 1) % 3] = 3 * slow;
          place[(axis + 2) % 3] = 3 * fast;
        }
  return places;
}

class SdfData {
 public:
  SdfData(const Eigen::AlignedBox3d& domain, double cell) : domain_(domain) {
    for (int k = 0; k < 3; ++k)
      count_[k] = std::clamp(int(std::ceil(domain.sizes()[k] / cell)), 1, kMaxSdfCells);
    cell_ = domain.sizes().cwiseQuotient(count_.cast<double>());
  }

  std::vector<char> bake(const std::function<double(const Vec3&)>& distance) {
    const std::vector<std::uint32_t> cells = numberNodes();
    const std::uint64_t cellCount = cells.size() / 32, fields = 1;
    for (int k = 0; k < 3; ++k) write(domain_.min()[k]);
    for (int k = 0; k < 3; ++k) write(domain_.max()[k]);
    for (int k = 0; k < 3; ++k) write(std::uint32_t(count_[k]));
    for (int k = 0; k < 3; ++k) write(cell_[k]);
    for (int k = 0; k < 3; ++k) write(1 / cell_[k]);
    write(cellCount);
    write(fields);
    write(fields);
    write(std::uint64_t(nodes_.size()));
    for (const Place& p : nodes_)
      write(distance(domain_.min() + cell_.cwiseProduct(Vec3(p[0], p[1], p[2]) / 3)));
    write(fields);
    write(cellCount);
    for (const std::uint32_t node : cells) write(node);
    write(fields);
    write(cellCount);
    for (std::uint32_t k = 0; k < cellCount; ++k) write(k);
    return std::move(bytes_);
  }

 private:
  template <class T>
  void write(const T& value) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof value);
    std::memcpy(bytes_.data() + at, &value, sizeof value);
  }

  // Returns the numbers of each cell's 32 nodes and fills nodes_.
  std::vector<std::uint32_t> numberNodes() {
    constexpr std::uint32_t none = UINT32_MAX;
    const Eigen::Matrix<std::size_t, 3, 1> lattice =
        (3 * count_ + Eigen::Vector3i::Ones()).cast<std::size_t>();
    std::vector<std::uint32_t> numberAt(lattice.prod(), none);
    const std::array<Place, 32> places = nodePlaces();
    std::vector<std::uint32_t> cells;
    for (int z = 0; z < count_[2]; ++z)
      for (int y = 0; y < count_[1]; ++y)
        for (int x = 0; x < count_[0]; ++x)
          for (const Place& p : places) {
            const Place at = {3 * x + p[0], 3 * y + p[1], 3 * z + p[2]};
            std::uint32_t& number =
                numberAt[(std::size_t(at[2]) * lattice[1] + std::size_t(at[1])) * lattice[0] +
                         std::size_t(at[0])];
            if (number == none) {
              number = std::uint32_t(nodes_.size());
              nodes_.push_back(at);
            }
            cells.push_back(number);
          }
    return cells;
  }

  Eigen::AlignedBox3d domain_;
  Eigen::Vector3i count_;
  Vec3 cell_;
  std::vector<Place> nodes_;
  std::vector<char> bytes_;
};

// Bakes `distance` [m], negative inside, over `domain` in cells of about `cell` [m], at most
// kMaxSdfCells along an axis. Bullet finds no contact outside the domain.
BulletShape bakedSdfShape(const std::function<double(const Vec3&)>& distance,
                          const Eigen::AlignedBox3d& domain, double cell) {
  const std::vector<char> bytes = SdfData(domain, cell).bake(distance);
  auto shape = std::make_shared<btSdfCollisionShape>();
  if (!shape->initializeSDF(bytes.data(), int(bytes.size())))
    throw std::runtime_error("btSdfCollisionShape rejects the distance field");
  return {{}, shape};
}

bool isSphere(const LabBody& body) {
  return body.shape && std::holds_alternative<Sphere>(*body.shape);
}

// Cubic cells represent the linear distance of a half-space exactly, so large cells suffice.
BulletShape planeSdf(const HalfSpace& plane, double reach) {
  const Vec3 half = Vec3::Constant(10 * reach), foot = plane.offset * plane.normal;
  return bakedSdfShape([&](const Vec3& p) { return -solidAt(plane, p).depth; },
                       Eigen::AlignedBox3d(foot - half, foot + half), 10 * reach);
}

// `pad`: distance from the surface up to which the other body's points are looked up [m].
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
  const auto takesSdf = [](const LabBody& body) { return body.convex && !isHalfSpace(body); };
  if (!takesSdf(a) && !takesSdf(b))
    throw CannotDo("btSdfCollisionShape only collides with spheres and convex polyhedra");
  const double tolerance = kFacetsOfCell * cell;
  const bool bakeA =
      !takesSdf(a) || (takesSdf(b) && reachOf(a, tolerance) >= reachOf(b, tolerance));
  const LabBody &field = bakeA ? a : b, &other = bakeA ? b : a;
  const double reach = reachOf(other, tolerance);
  BulletShape sdf = isHalfSpace(field) ? planeSdf(std::get<HalfSpace>(*field.shape), reach)
                                       : sdfOf(field, cell, isSphere(other) ? reach : 0);
  BulletShape convex = isSphere(other) ? primitiveShape(*other.shape) : hullOf(other, tolerance);
  if (!bakeA) std::swap(sdf, convex);
  return probed(sdf, convex, Method::Sdf);
}

}  // namespace

std::vector<LabMethod> bulletMethods() {
  std::vector<LabMethod> methods = {{"primitive", "Bullet's own shapes", 0, primitivePair,
                                     "sphere, box, capsule, cylinder, cone, plane with Bullet's "
                                     "default margins inside them; for cones, whose margin is "
                                     "outside, " +
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
                           "a cell; the other body is a sphere or the hull of such facets, " +
                           kMargin});
  std::vector<LabMethod> all;
  for (const LabMethod& method : methods) all.push_back(atMeterScale(method));
  return all;
}

}  // namespace cloudcontact::program::lab
