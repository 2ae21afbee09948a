// Moves the faces of a hypothesis so that they reproduce a block's coverage (Gauss-Newton).
#pragma once

#include "field/edge_block.h"

namespace cloudcontact {

// Faces that explain a block.
struct Hypothesis {
  Face faces[kMostEdgeFaces];
  int count = 0;
  bool concave = false;
  float residual = 1.0f;
};

// Moves all faces of a hypothesis at once to fit the target coverage. A prior holds each face near
// its start, weighted by how well its neighbors know it. Gives up where it foresees that the
// residual will stay well above `useful`. `start` holds the hypothesis' faces as they are; `fields`
// is workspace.
void refine(const BlockTarget& target, float useful, const Combination& start, Hypothesis& h,
            FaceField* fields);

}  // namespace cloudcontact
