// BallTree: a field's surface in a tree of balls, for lower bounds on how far two bodies are apart.
#pragma once

#include "field/sample_set.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace cloudcontact {

class FieldData;

// A node's ball holds the finest samples of some cells of the coarsest level, to their borders. A
// leaf is one cell, four voxels wide.
class BallTree {
 public:
  // In voxels of the grid. A node's children are the next one and `far`; 0 of a leaf.
  struct Node {
    Eigen::Vector3f center;
    float radius;
    std::uint32_t far;
  };

  explicit BallTree(const SampleSet& samples);

  // The root comes first. Empty where there are no samples.
  const std::vector<Node>& nodes() const { return nodes_; }

 private:
  struct Ball {
    Eigen::Vector3f center;
    float radius;
  };
  static Ball ballOf(const SampleSet& samples, const SampleRun& ofMiddle);
  void divide(Ball* first, Ball* last);

  std::vector<Node> nodes_;
};

// The field's tree. The first call makes it; calls may come from several threads.
const BallTree& ballTree(const FieldData& field);

}  // namespace cloudcontact
