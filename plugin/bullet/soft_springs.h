// SoftSprings: what the links of soft tissue do to its nodes in one step.
#pragma once

#include <vector>

#include "bullet/soft_lattice.h"

namespace cloudcontact {

// A node in a step.
struct SoftNode {
  Vec3 start = Vec3::Zero();  // at the start of the step [m]
  Vec3 place = Vec3::Zero();  // where it would end without links, then where it ends [m]
  double inverseMass = 0;     // [1/kg] 0: pinned
};

// Keeps its memory between calls: a step after the first allocates nothing.
class SoftSprings {
 public:
  // Backward Euler: moves the nodes' places to where the links' forces at the step's end bring
  // them. `pieces`: of each node, the number of the piece to which it belongs.
  void step(const std::vector<SoftLink>& links, const std::vector<int>& pieces,
            std::vector<SoftNode>& nodes, double seconds);
  // The largest displacement by the forces that the last step left unbalanced [m].
  double missed() const { return missed_; }

 private:
  struct Row {  // a link in the current state: its force's change with its length and its turn
    Vec3 along = Vec3::Zero();
    double stiff = 0, turn = 0;  // [kg], as all is times the step squared
  };
  double energy(const std::vector<SoftLink>& links, const std::vector<SoftNode>& nodes) const;
  void linearize(const std::vector<SoftLink>& links, const std::vector<SoftNode>& nodes);
  void multiply(const std::vector<SoftLink>& links, const std::vector<SoftNode>& nodes);
  void solve(const std::vector<SoftLink>& links, const std::vector<SoftNode>& nodes);
  void keepMomentum(const std::vector<int>& pieces, std::vector<SoftNode>& nodes);
  bool advance(const std::vector<SoftLink>& links, std::vector<SoftNode>& nodes);

  double square_ = 0, step_ = 0;  // of the step [s^2, s]
  double missed_ = 0;
  std::vector<double> before_;  // length of each link at the step's start [m]
  std::vector<Vec3> free_;      // each node without links
  std::vector<Row> rows_;
  std::vector<Vec3> astray_;              // of each piece: mass times displacement [kg m]
  std::vector<double> heavy_;             // of each piece: mass [kg]; infinite if a node is pinned
  std::vector<Eigen::Matrix3d> inverse_;  // of each node's own block
  std::vector<Vec3> residual_, change_, direction_, image_, scaled_;
};

}  // namespace cloudcontact
