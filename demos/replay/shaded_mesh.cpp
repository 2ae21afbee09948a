// The normal at a triangle's corner is the sum of the normals of the faces around that vertex,
// weighted by their angle there, over faces within the crease angle.
#include "replay/shaded_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_map>

namespace cloudcontact::program {
namespace {

constexpr std::size_t kMostFaces = 400;  // larger fans are shaded flat

using Vector = Eigen::Vector3d;

struct Corner {
  int triangle;
  double angle;
};

// The faces around each vertex, in one array.
struct Fans {
  std::vector<std::size_t> first;
  std::vector<Corner> corners;
};

double angleAt(const Mesh& mesh, const Eigen::Vector3i& t, int k) {
  const Vector& at = mesh.vertices[static_cast<std::size_t>(t[k])];
  const Vector u = mesh.vertices[static_cast<std::size_t>(t[(k + 1) % 3])] - at;
  const Vector v = mesh.vertices[static_cast<std::size_t>(t[(k + 2) % 3])] - at;
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

Fans fansOf(const Mesh& mesh) {
  Fans fans;
  fans.first.assign(mesh.vertices.size() + 1, 0);
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) ++fans.first[static_cast<std::size_t>(t[k]) + 1];
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) fans.first[v + 1] += fans.first[v];
  fans.corners.resize(fans.first.back());
  std::vector<std::size_t> next(fans.first.begin(), fans.first.end() - 1);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k)
      fans.corners[next[static_cast<std::size_t>(mesh.triangles[i][k])]++] = {
          static_cast<int>(i), angleAt(mesh, mesh.triangles[i], k)};
  return fans;
}

std::vector<Vector> faceNormals(const Mesh& mesh) {
  std::vector<Vector> normals;
  for (const auto& t : mesh.triangles) {
    const Vector& a = mesh.vertices[static_cast<std::size_t>(t[0])];
    const Vector across = (mesh.vertices[static_cast<std::size_t>(t[1])] - a)
                              .cross(mesh.vertices[static_cast<std::size_t>(t[2])] - a);
    const double length = across.norm();
    normals.push_back(length > 0 ? Vector(across / length) : Vector(Vector::UnitZ()));
  }
  return normals;
}

// Merges vertices of equal position and normal.
class Vertices {
 public:
  explicit Vertices(ShadedMesh& out) : out_(out) {}
  std::uint32_t index(int vertex, const Vector& position, const Vector& normal) {
    std::uint64_t key = static_cast<std::uint64_t>(vertex);
    for (int axis = 0; axis < 3; ++axis)
      key = key << 10 | static_cast<std::uint64_t>(std::lround(500 * (normal[axis] + 1)));
    const auto [found, isNew] =
        known_.try_emplace(key, static_cast<std::uint32_t>(out_.positions.size()));
    if (isNew) {
      out_.positions.push_back(position.cast<float>());
      out_.normals.push_back(normal.cast<float>());
    }
    return found->second;
  }

 private:
  ShadedMesh& out_;
  std::unordered_map<std::uint64_t, std::uint32_t> known_;
};

}  // namespace

ShadedMesh shaded(const Mesh& mesh, double crease) {
  const Fans fans = fansOf(mesh);
  const std::vector<Vector> faces = faceNormals(mesh);
  const double alike = std::cos(crease);
  ShadedMesh out;
  Vertices vertices(out);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(mesh.triangles[i][k]);
      Vector sum = Vector::Zero();
      if (fans.first[v + 1] - fans.first[v] <= kMostFaces)
        for (std::size_t c = fans.first[v]; c < fans.first[v + 1]; ++c) {
          const Vector& other = faces[static_cast<std::size_t>(fans.corners[c].triangle)];
          if (other.dot(faces[i]) >= alike) sum += fans.corners[c].angle * other;
        }
      const Vector normal = sum.norm() > 0 ? Vector(sum.normalized()) : faces[i];
      out.corners.push_back(vertices.index(mesh.triangles[i][k], mesh.vertices[v], normal));
    }
  }
  return out;
}

Mesh welded(const Mesh& mesh) {
  const std::size_t count = mesh.vertices.size();
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  const auto place = [&](std::size_t i) {
    const Eigen::Vector3d& v = mesh.vertices[i];
    return std::array{v.x(), v.y(), v.z()};
  };
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return place(a) < place(b); });
  Mesh out;
  std::vector<int> number(count);
  for (std::size_t k = 0; k < count; ++k) {
    if (k == 0 || place(order[k]) != place(order[k - 1]))
      out.vertices.push_back(mesh.vertices[order[k]]);
    number[order[k]] = static_cast<int>(out.vertices.size()) - 1;
  }
  for (const Eigen::Vector3i& t : mesh.triangles)
    out.triangles.emplace_back(number[static_cast<std::size_t>(t[0])],
                               number[static_cast<std::size_t>(t[1])],
                               number[static_cast<std::size_t>(t[2])]);
  return out;
}

}  // namespace cloudcontact::program
