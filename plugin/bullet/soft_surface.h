// SoftSurface: the surface of soft tissue. Each node has an eighth of each cell around it. Where a
// link between two nodes of an edge is cut, their eighths of the cells at that edge part.
#pragma once

#include <cloudcontact/mesh/mesh.h>

#include <array>
#include <vector>

#include "bullet/soft_lattice.h"

namespace cloudcontact {

class SoftSurface {
 public:
  explicit SoftSurface(const SoftLattice& lattice);

  void part(const SoftLink& link);  // it is cut
  // With the nodes at `places`.
  Mesh mesh(const std::vector<Vec3>& places) const;
  // Of the surface around each node [m^2].
  std::vector<double> areas(const std::vector<Vec3>& places) const;

 private:
  struct Eighth;
  template <class Visit>
  void visit(const std::vector<Vec3>& places, const Visit& visit) const;
  bool joined(const SoftCell& cell, int corner, int axis) const;
  bool allJoined(const SoftCell& cell, int corner, int e, int f) const;
  Vec3 half(const SoftCell& cell, int corner, int axis, const std::vector<Vec3>& places) const;
  Eighth eighth(const SoftCell& cell, int corner, const std::vector<Vec3>& places) const;

  const std::vector<SoftCell>& cells_;
  Vec3 cell_;
  // Of each node and axis: the node at the upper and at the lower end of its edge, or -1.
  std::vector<std::array<std::array<int, 2>, 3>> next_;
};

}  // namespace cloudcontact
