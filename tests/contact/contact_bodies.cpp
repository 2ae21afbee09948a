// The bodies of the contact cases: random numbers, meshes of ideal solids and their clouds.
#include <cloudcontact/voxels/digitize.h>

#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "contact/contact_cases.h"

namespace cloudcontact::testing {

double Random::uniform() {
  state_ += 0x9e3779b97f4a7c15u;
  std::uint64_t z = state_;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

Vec3 Random::inCube() {
  const double x = uniform(), y = uniform();
  return {x, y, uniform()};
}

Eigen::Quaterniond Random::rotation() {
  // Shoemake: uniform over the unit quaternions.
  const double u = uniform(), a = 2 * std::numbers::pi * uniform(),
               b = 2 * std::numbers::pi * uniform();
  return {std::sqrt(u) * std::cos(b), std::sqrt(1 - u) * std::sin(a),
          std::sqrt(1 - u) * std::cos(a), std::sqrt(u) * std::sin(b)};
}

Eigen::Quaterniond Random::yaw() {
  return Eigen::Quaterniond(Eigen::AngleAxisd(uniform(0, 2 * std::numbers::pi), Vec3::UnitZ()));
}

Hull boxAsHull(const Vec3& half) {
  Hull hull;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0})
      hull.planes.push_back({side * Vec3::Unit(axis), half[axis]});
  for (int corner = 0; corner < 8; ++corner) {
    hull.corners.push_back(
        half.cwiseProduct(Vec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1)));
    for (int axis = 0; axis < 3; ++axis)
      if (!(corner >> axis & 1)) hull.edges.emplace_back(corner, corner | 1 << axis);
  }
  return hull;
}

Mesh boxMesh(const Vec3& edges) {
  Mesh mesh;
  for (int k = 0; k < 8; ++k) {
    const Vec3 sign((k & 1) - 0.5, ((k >> 1) & 1) - 0.5, ((k >> 2) & 1) - 0.5);
    mesh.vertices.push_back(sign.cwiseProduct(edges));
  }
  const int quads[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                           {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& q : quads) {
    mesh.triangles.emplace_back(q[0], q[1], q[2]);
    mesh.triangles.emplace_back(q[0], q[2], q[3]);
  }
  return mesh;
}

namespace {

Mesh icosahedron() {
  const double g = std::numbers::phi;
  Mesh mesh;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-g, g}) {
      mesh.vertices.emplace_back(0, a, b);
      mesh.vertices.emplace_back(a, b, 0);
      mesh.vertices.emplace_back(b, 0, a);
    }
  }
  // Three corners form a face if each two are an edge (2) apart. Oriented outward.
  const auto& v = mesh.vertices;
  const auto near = [&](int i, int j) { return (v[i] - v[j]).norm() < 2.1; };
  for (int i = 0; i < 12; ++i) {
    for (int j = i + 1; j < 12; ++j) {
      for (int k = j + 1; k < 12; ++k) {
        if (!near(i, j) || !near(j, k) || !near(i, k)) continue;
        const bool outward = v[i].dot(v[j].cross(v[k])) > 0;
        mesh.triangles.emplace_back(i, outward ? j : k, outward ? k : j);
      }
    }
  }
  return mesh;
}

// Splits each triangle into four, with new vertices on the unit sphere.
Mesh refined(const Mesh& coarse) {
  Mesh mesh;
  mesh.vertices = coarse.vertices;
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int i, int j) {
    const auto [at, isNew] = middles.try_emplace(std::minmax(i, j), mesh.vertices.size());
    if (isNew) mesh.vertices.push_back((mesh.vertices[i] + mesh.vertices[j]).normalized());
    return at->second;
  };
  for (const auto& t : coarse.triangles) {
    const int a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
    mesh.triangles.emplace_back(t[0], a, c);
    mesh.triangles.emplace_back(a, t[1], b);
    mesh.triangles.emplace_back(c, b, t[2]);
    mesh.triangles.emplace_back(a, b, c);
  }
  return mesh;
}

double volumeOf(const Mesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    sum += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]])) / 6;
  }
  return sum;
}

}  // namespace

Mesh sphereMesh(double radius, double tolerance) {
  Mesh mesh = icosahedron();
  for (Vec3& v : mesh.vertices) v.normalize();
  // The middle of a facet with edge e lies (e / sqrt 3)^2 / 2r inside the sphere. Keeping the
  // volume spreads this evenly to both sides. The first edge is 1.0515 r; the longest shrinks by
  // 0.52.
  for (double edge = 1.18; radius * edge * edge / 12 > tolerance; edge /= 2) mesh = refined(mesh);
  const double grow = std::cbrt(4 * std::numbers::pi / 3 / volumeOf(mesh));
  for (Vec3& v : mesh.vertices) v *= grow * radius;
  return mesh;
}

Mesh cylinderMesh(double radius, double height, double tolerance) {
  const int n = std::max(12, int(std::ceil(std::numbers::pi / std::sqrt(tolerance / radius))));
  const double turn = 2 * std::numbers::pi / n;
  const double corner =
      radius * std::sqrt(turn / std::sin(turn));  // keeps the cross-section's area
  Mesh mesh;
  mesh.vertices = {{0, 0, -height / 2}, {0, 0, height / 2}};
  for (int k = 0; k < n; ++k) {
    const double x = corner * std::cos(turn * k), y = corner * std::sin(turn * k);
    mesh.vertices.emplace_back(x, y, -height / 2);
    mesh.vertices.emplace_back(x, y, height / 2);
  }
  for (int k = 0; k < n; ++k) {
    const int low = 2 + 2 * k, next = 2 + 2 * ((k + 1) % n);
    mesh.triangles.emplace_back(0, next, low);
    mesh.triangles.emplace_back(1, low + 1, next + 1);
    mesh.triangles.emplace_back(low, next, next + 1);
    mesh.triangles.emplace_back(low, next + 1, low + 1);
  }
  return mesh;
}

Mesh transformed(const Mesh& mesh, const Pose& pose) {
  Mesh moved = mesh;
  for (Vec3& v : moved.vertices) v = pose.toWorld(v);
  return moved;
}

ContactBody Body::at(const Pose& pose) const {
  ContactBody body;
  body.field = field.get();
  body.shape = shape ? &*shape : nullptr;
  body.pose = pose * grid.inverse();
  return body;
}

Body BodyMaker::cloud(const Mesh& mesh, bool aligned) {
  Body body;
  if (!aligned) body.grid.orientation = random.rotation();
  body.grid.position = voxel * random.inCube();
  DigitizeSettings settings;
  settings.voxelSize = voxel;
  settings.threads = 1;
  FieldSettings fieldSettings = field;
  fieldSettings.threads = 1;
  body.field = SurfaceField::build(digitize(transformed(mesh, body.grid), settings), fieldSettings);
  return body;
}

// Facet tolerance, well below the smallest bound (3 % of 0.3 voxel).
constexpr double kTolerance = 0.003;  // [voxels]

Body BodyMaker::box(const Vec3& voxels, bool aligned) {
  return cloud(boxMesh(voxel * voxels), aligned);
}

Body BodyMaker::sphere(double radiusVoxels) {
  return cloud(sphereMesh(voxel * radiusVoxels, voxel * kTolerance));
}

Body BodyMaker::cylinder(double radiusVoxels, double heightVoxels) {
  return cloud(cylinderMesh(voxel * radiusVoxels, voxel * heightVoxels, voxel * kTolerance));
}

Body BodyMaker::shape(const Solid& analytic) {
  Body body;
  body.shape = analytic;
  return body;
}

}  // namespace cloudcontact::testing
