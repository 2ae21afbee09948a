// SoftLattice: the nodes, links and cells of soft tissue, made from a cloud.
#pragma once

#include <cloudcontact/bullet/node_matter.h>
#include <cloudcontact/law/tissue.h>
#include <cloudcontact/voxels/cloud.h>

#include <array>
#include <vector>

namespace cloudcontact {

struct SoftLink {
  int a = 0, b = 0;      // nodes
  double length = 0;     // at rest [m]
  double stiffness = 0;  // [N/m]
  double damping = 0;    // [N s/m]
  int axis = -1;         // 0..2 where it is an edge of cells, from a to b; -1: a diagonal
};

// A box of eight nodes. Corner i lies on the upper side along axis e where bit e of i is set.
struct SoftCell {
  std::array<int, 8> nodes;
  std::array<bool, 6> open;  // no cell beyond its face 2 axis + side
};

struct SoftLattice {
  std::vector<Vec3> places;  // of the nodes at rest, in the cloud's frame [m]
  std::vector<NodeMatter> matter;
  std::vector<SoftLink> links;  // sorted by nodes
  std::vector<SoftCell> cells;
  Vec3 cell = Vec3::Zero();  // edges [m]
};

// Throws std::invalid_argument as SoftTissue does.
SoftLattice softLattice(const Cloud& cloud, const TissueTable& tissues, double spacing);

}  // namespace cloudcontact
