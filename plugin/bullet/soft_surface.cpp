// An eighth of a cell is a box with a corner at its node, one in the middle of each of three edges,
// one in the middle of each of three faces, and one in the middle of the cell. Whole faces and
// cells have one middle for all their eighths. Where an edge is cut, each side goes on as the edge
// on the node's other side does.
#include "bullet/soft_surface.h"

#include <Eigen/Geometry>

namespace cloudcontact {

struct SoftSurface::Eighth {
  Vec3 node;
  std::array<Vec3, 3> edge;  // the middle of each axis' edge
  std::array<Vec3, 3> face;  // the middle of the face across each axis
  Vec3 cell;
};

SoftSurface::SoftSurface(const SoftLattice& lattice)
    : cells_(lattice.cells),
      cell_(lattice.cell),
      next_(lattice.places.size(), {{{-1, -1}, {-1, -1}, {-1, -1}}}) {
  for (const SoftLink& link : lattice.links) {
    if (link.axis < 0) continue;
    const auto axis = static_cast<std::size_t>(link.axis);
    next_[static_cast<std::size_t>(link.a)][axis][0] = link.b;
    next_[static_cast<std::size_t>(link.b)][axis][1] = link.a;
  }
}

void SoftSurface::part(const SoftLink& link) {
  if (link.axis < 0) return;
  const auto axis = static_cast<std::size_t>(link.axis);
  next_[static_cast<std::size_t>(link.a)][axis][0] = -1;
  next_[static_cast<std::size_t>(link.b)][axis][1] = -1;
}

bool SoftSurface::joined(const SoftCell& cell, int corner, int axis) const {
  const int node = cell.nodes[static_cast<std::size_t>(corner)];
  return next_[static_cast<std::size_t>(node)][static_cast<std::size_t>(axis)]
              [static_cast<std::size_t>(corner >> axis & 1)] >= 0;
}

// The four edges of the face through a corner.
bool SoftSurface::allJoined(const SoftCell& cell, int corner, int e, int f) const {
  return joined(cell, corner, e) && joined(cell, corner, f) && joined(cell, corner ^ 1 << e, f) &&
         joined(cell, corner ^ 1 << f, e);
}

// From a corner to the middle of its edge.
Vec3 SoftSurface::half(const SoftCell& cell, int corner, int axis,
                       const std::vector<Vec3>& places) const {
  const auto place = [&](int i) {
    return places[static_cast<std::size_t>(cell.nodes[static_cast<std::size_t>(i)])];
  };
  if (joined(cell, corner, axis)) return 0.5 * (place(corner ^ 1 << axis) - place(corner));
  const auto node = static_cast<std::size_t>(cell.nodes[static_cast<std::size_t>(corner)]);
  const int upper = corner >> axis & 1;
  const int behind =
      next_[node][static_cast<std::size_t>(axis)][static_cast<std::size_t>(1 - upper)];
  if (behind >= 0) return 0.5 * (places[node] - places[static_cast<std::size_t>(behind)]);
  return (upper ? -0.5 : 0.5) * cell_[axis] * Vec3::Unit(axis);
}

SoftSurface::Eighth SoftSurface::eighth(const SoftCell& cell, int corner,
                                        const std::vector<Vec3>& places) const {
  const auto place = [&](int i) {
    return places[static_cast<std::size_t>(cell.nodes[static_cast<std::size_t>(i)])];
  };
  Eighth out;
  out.node = place(corner);
  out.cell = out.node;
  bool whole = true;
  for (int e = 0; e < 3; ++e) {
    const int f = (e + 1) % 3, g = (e + 2) % 3;
    const auto axis = static_cast<std::size_t>(e);
    const Vec3 step = half(cell, corner, e, places);
    // Sums in an order of their own, so that all eighths around have the same point, to the bit.
    out.edge[axis] = joined(cell, corner, e) ? Vec3(0.5 * (place(corner) + place(corner ^ 1 << e)))
                                             : Vec3(out.node + step);
    out.cell += step;
    const int opposite = corner ^ 1 << e, low = corner & ~(1 << f | 1 << g);
    whole = whole && allJoined(cell, corner, f, g) && allJoined(cell, opposite, f, g) &&
            joined(cell, corner, e);
    out.face[axis] =
        allJoined(cell, corner, f, g)
            ? Vec3(0.25 * (place(low) + place(low ^ 1 << f) + place(low ^ 1 << g) +
                           place(low ^ (1 << f | 1 << g))))
            : Vec3(out.node + half(cell, corner, f, places) + half(cell, corner, g, places));
  }
  if (!whole) return out;
  out.cell.setZero();
  for (int i = 0; i < 8; ++i) out.cell += 0.125 * place(i);
  return out;
}

// Calls visit(node, four corners) for each piece of the surface, counter-clockwise from outside.
template <class Visit>
void SoftSurface::visit(const std::vector<Vec3>& places, const Visit& visit) const {
  for (const SoftCell& cell : cells_)
    for (int corner = 0; corner < 8; ++corner) {
      const Eighth box = eighth(cell, corner, places);
      const int node = cell.nodes[static_cast<std::size_t>(corner)];
      const bool mirrored = (corner & 1) ^ (corner >> 1 & 1) ^ (corner >> 2 & 1);
      for (std::size_t e = 0; e < 3; ++e) {
        const std::size_t f = (e + 1) % 3, g = (e + 2) % 3;
        const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d,
                             bool turned) {
          if (turned)
            visit(node, std::array<Vec3, 4>{a, d, c, b});
          else
            visit(node, std::array<Vec3, 4>{a, b, c, d});
        };
        if (cell.open[2 * e + static_cast<std::size_t>(corner >> e & 1)])
          add(box.node, box.edge[f], box.face[e], box.edge[g], !mirrored);
        if (!joined(cell, corner, static_cast<int>(e)))
          add(box.edge[e], box.face[g], box.cell, box.face[f], mirrored);
      }
    }
}

Mesh SoftSurface::mesh(const std::vector<Vec3>& places) const {
  Mesh mesh;
  visit(places, [&](int, const std::array<Vec3, 4>& corners) {
    const int first = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), corners.begin(), corners.end());
    mesh.triangles.emplace_back(first, first + 1, first + 2);
    mesh.triangles.emplace_back(first, first + 2, first + 3);
  });
  return mesh;
}

std::vector<double> SoftSurface::areas(const std::vector<Vec3>& places) const {
  std::vector<double> areas(next_.size());
  visit(places, [&](int node, const std::array<Vec3, 4>& corners) {
    const Vec3 across = (corners[2] - corners[0]).cross(corners[3] - corners[1]);
    areas[static_cast<std::size_t>(node)] += 0.5 * across.norm();
  });
  return areas;
}

}  // namespace cloudcontact
