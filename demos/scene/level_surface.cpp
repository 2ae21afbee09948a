// Surface nets (Gibson, MICCAI 1998). Each cell that the surface crosses gets one vertex, the mean
// of the crossings of its edges; each crossed edge gets a quadrilateral of its four cells. Closed,
// because everything beyond the grid counts as outside.
#include "scene/level_surface.h"

#include <array>
#include <cmath>
#include <stdexcept>

namespace cloudcontact::program {

namespace {

constexpr double kMostCells = 1 << 28;

// Values at the nodes of a grid whose rim is outside.
struct Nodes {
  Eigen::Vector3i size = Eigen::Vector3i::Zero();
  Vec3 origin = Vec3::Zero();  // of node (0,0,0) [m]
  double cell = 0;             // [m]
  std::vector<float> values;

  std::size_t index(const Eigen::Vector3i& n) const {
    return static_cast<std::size_t>(n.x()) +
           static_cast<std::size_t>(size.x()) *
               (static_cast<std::size_t>(n.y()) +
                static_cast<std::size_t>(size.y()) * static_cast<std::size_t>(n.z()));
  }
  double at(const Eigen::Vector3i& n) const { return static_cast<double>(values[index(n)]); }
  bool inside(const Eigen::Vector3i& n) const { return values[index(n)] > 0; }
};

template <typename Value>
Nodes sampled(const Eigen::Vector3i& inner, const Vec3& origin, double cell, Value&& value) {
  Nodes nodes{inner + Eigen::Vector3i::Constant(2), origin - Vec3::Constant(cell), cell, {}};
  nodes.values.assign(static_cast<std::size_t>(nodes.size.cast<long>().prod()), -1.f);
  for (int z = 0; z < inner.z(); ++z)
    for (int y = 0; y < inner.y(); ++y)
      for (int x = 0; x < inner.x(); ++x)
        nodes.values[nodes.index(Eigen::Vector3i(x + 1, y + 1, z + 1))] =
            static_cast<float>(value(x, y, z));
  return nodes;
}

Eigen::Vector3i corner(int k) {
  return {k & 1, k >> 1 & 1, k >> 2};
}

// Mean of the crossings of the cell's edges; false if there is none.
bool vertexOf(const Nodes& nodes, const Eigen::Vector3i& cell, Vec3& vertex) {
  Vec3 sum = Vec3::Zero();
  int crossings = 0;
  for (int from = 0; from < 8; ++from)
    for (int axis = 0; axis < 3; ++axis) {
      if (from >> axis & 1) continue;
      const Eigen::Vector3i a = corner(from), b = a + Eigen::Vector3i::Unit(axis);
      if (nodes.inside(cell + a) == nodes.inside(cell + b)) continue;
      const double low = nodes.at(cell + a), high = nodes.at(cell + b);
      sum += a.cast<double>() + low / (low - high) * Vec3::Unit(axis);
      ++crossings;
    }
  if (crossings == 0) return false;
  vertex = nodes.origin + nodes.cell * (cell.cast<double>() + sum / crossings);
  return true;
}

// Split along its shorter diagonal.
void addQuad(Mesh& mesh, std::array<int, 4> q, bool turned) {
  if (turned) std::swap(q[1], q[3]);
  const auto apart = [&](int a, int b) {
    return (mesh.vertices[static_cast<std::size_t>(q[static_cast<std::size_t>(a)])] -
            mesh.vertices[static_cast<std::size_t>(q[static_cast<std::size_t>(b)])])
        .squaredNorm();
  };
  if (apart(0, 2) <= apart(1, 3)) {
    mesh.triangles.emplace_back(q[0], q[1], q[2]);
    mesh.triangles.emplace_back(q[0], q[2], q[3]);
  } else {
    mesh.triangles.emplace_back(q[0], q[1], q[3]);
    mesh.triangles.emplace_back(q[1], q[2], q[3]);
  }
}

Mesh surfaceOf(const Nodes& nodes) {
  Mesh mesh;
  std::vector<int> vertices(nodes.values.size(), -1);  // of the cell above each node
  const auto forEach = [](const Eigen::Vector3i& low, const Eigen::Vector3i& high, auto&& what) {
    for (int z = low.z(); z < high.z(); ++z)
      for (int y = low.y(); y < high.y(); ++y)
        for (int x = low.x(); x < high.x(); ++x) what(Eigen::Vector3i(x, y, z));
  };
  forEach(Eigen::Vector3i::Zero(), nodes.size - Eigen::Vector3i::Ones(),
          [&](const Eigen::Vector3i& cell) {
            Vec3 vertex;
            if (!vertexOf(nodes, cell, vertex)) return;
            vertices[nodes.index(cell)] = static_cast<int>(mesh.vertices.size());
            mesh.vertices.push_back(vertex);
          });
  // Edges within the rim have four cells; the surface never crosses edges of the rim.
  forEach(
      Eigen::Vector3i::Zero(), nodes.size - Eigen::Vector3i::Ones(),
      [&](const Eigen::Vector3i& node) {
        for (int axis = 0; axis < 3; ++axis) {
          const bool inside = nodes.inside(node);
          if (inside == nodes.inside(node + Eigen::Vector3i::Unit(axis))) continue;
          const Eigen::Vector3i b = Eigen::Vector3i::Unit((axis + 1) % 3),
                                c = Eigen::Vector3i::Unit((axis + 2) % 3);
          const auto cell = [&](const Eigen::Vector3i& at) { return vertices[nodes.index(at)]; };
          addQuad(mesh, {cell(node - b - c), cell(node - c), cell(node), cell(node - b)}, !inside);
        }
      });
  return mesh;
}

}  // namespace

Mesh levelSurface(const LevelFunction& inside, const Eigen::AlignedBox3d& box, double cell) {
  if (!(cell > 0) || !std::isfinite(cell) || box.isEmpty())
    throw std::invalid_argument("levelSurface: the cell must be positive and the box not empty");
  const Vec3 size = (box.sizes() / cell).array().ceil() + 1;
  if (!(size.prod() <= kMostCells))
    throw std::invalid_argument("levelSurface: too many cells; take larger ones");
  return surfaceOf(sampled(size.cast<int>(), box.min(), cell, [&](int x, int y, int z) {
    return inside(box.min() + cell * Vec3(x, y, z));
  }));
}

Mesh cloudSurface(const Cloud& cloud, int step) {
  if (step < 1) throw std::invalid_argument("cloudSurface: the step must be positive");
  if (cloud.empty()) return {};
  const double h = cloud.voxelSize();
  const Eigen::Vector3i blocks = (cloud.size().array() + step - 1) / step;
  const auto mean = [&](int x, int y, int z) {
    int sum = 0;
    for (int k = 0; k < step * step * step; ++k)
      sum += cloud.coverage(step * x + k % step, step * y + k / step % step,
                            step * z + k / (step * step));
    return sum / (255.0 * step * step * step) - 0.5;
  };
  return surfaceOf(
      sampled(blocks, cloud.origin() + Vec3::Constant(0.5 * step * h), step * h, mean));
}

}  // namespace cloudcontact::program
