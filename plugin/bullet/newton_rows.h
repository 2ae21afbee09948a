// NewtonRows: the rows of an island, solved together.
#pragma once

#include <BulletDynamics/ConstraintSolver/btSolverBody.h>
#include <BulletDynamics/ConstraintSolver/btSolverConstraint.h>

#include <cstddef>
#include <limits>
#include <vector>

#include "bullet/block_cholesky.h"

namespace cloudcontact {

// A row's impulse is the clamped (free speed - J u) / softness, with u the change of the bodies'
// velocities that all rows make. For given limits the solution is where a convex function of u is
// least, half the bodies' kinetic energy by u and the rows' own: quadratic while a row is within
// its limits, straight beyond. Newton's method finds it in a few steps, whatever the masses and
// stiffnesses, where sweeps need one for each body that weight passes through.
//
// - A step is solved directly (BlockCholesky), in velocities times the root of the mass.
// - The first step takes the rows that the last sweep left within their limits, and goes its whole
//   way: that alone is the solution where rows neither open nor slide.
// - Along the others the function's least is found exactly, by going from kink to kink.
// - A row that would pass its range within the step counts in the next ones with its mean slope
//   over this one, less and less. Without, steps stop at the first rows that turn about, one after
//   another.
// - Limits of friction follow the normal impulses each time that a step has reached its end. By
//   themselves they close in slowly, at 60 Hz by a tenth a step: what friction holds presses what
//   it lies on. So where they would not agree soon at that rate, they go to where limits and
//   impulses agree while each row stays as it is, within its limits or at one: a linear problem
//   (foresee()), by the matrix at hand. Limits that follow sooner jam pegs in their holes.
// - Where bodies are jammed, friction presses what it holds by more than it takes to hold it, and
//   limits that follow impulses grow or swing forever. Whatever the limits, where the function is
//   least no energy comes from nowhere, as friction only takes. So limits that come no nearer only
//   shrink from there on: they end, and what slides is held by no more than Coulomb's law says.
// - Rows without a softness of their own get one around the impulse that they have.
class NewtonRows {
 public:
  // Bullet's pools of an island.
  struct Pools {
    const btConstraintArray &joints, &contacts, &frictions, &rolling;
  };

  // Impulses of all rows, pool by pool, from those that they have. `speed` [m/s]: by how much they
  // may miss. Valid until the next call.
  const std::vector<double>& solve(const Pools& pools,
                                   const btAlignedObjectArray<btSolverBody>& bodies, double speed);
  // Whether friction's limits are those of the impulses. If not, they are less where rows slide;
  // sweeps would raise them again, so the impulses are the step's last ones.
  bool agree() const { return agree_; }
  std::size_t steps() const { return steps_; }  // of all calls

 private:
  static constexpr int kSize = BlockCholesky::kSize;
  struct Row {
    double of[2][kSize] = {};  // J times the root of the bodies' inverse masses
    int body[2] = {};          // numbers of those that move, bodies_ for others
    int pair = -1;             // of pairs_
    int normal = -1;           // the row whose impulse limits it
    double free = 0;           // [m/s]
    double soft = 1;           // [1/kg]
    double inverse = 0;        // J M^-1 J^T [1/kg]
    double low = 0, high = 0;  // limits [N s]
    double friction = 0, most = std::numeric_limits<double>::infinity();  // of `high`
    double side = 0;        // of the limit that it is at: 1 or -1
    double unit = 1;        // of foresee(): an impulse that gives the row one unit of energy
    double slope = 0;       // of the impulse over the last step, if it was at a limit [kg]
    double weight = 0;      // in the matrix [kg]
    double apart = 0;       // free - J u [m/s]
    double along = 0;       // J times Newton's step [m/s]
    bool isWithin = false;  // its limits
  };
  // Changes of friction's limits, what limits want that they answer, and its square.
  struct Answered {
    std::vector<double> change, wants;
    double square = 0;
  };
  static constexpr int kAnswers = 3;  // more are hardly nearer
  struct Kink {
    double at, slope;
    bool operator<(const Kink& o) const { return at != o.at ? at < o.at : slope < o.slope; }
  };

  void number(const btAlignedObjectArray<btSolverBody>& bodies);
  void read(const Pools& pools, const btAlignedObjectArray<btSolverBody>& bodies);
  bool readRow(const btSolverConstraint& from, const btAlignedObjectArray<btSolverBody>& bodies,
               Row& row) const;
  void findPairs();
  void begin();
  int classify(bool byImpulses);
  void weigh(Row& row, double weight);
  double alongStep(const Row& row) const;
  double measureStep();
  double lengthOfStep();
  void move(double length);
  void answer(const std::vector<double>& changes, std::vector<double>& answers);
  void foresee();
  double followNormals(double speed, bool foresees);

  std::vector<Row> rows_;
  std::size_t firstFriction_ = 0;
  int bodies_ = 0;
  struct Moved {
    int number = -1;
    double root[kSize] = {};  // of the inverse inertia, by columns of its lower triangle
  };
  std::vector<Moved> moved_;  // by Bullet's numbers
  std::vector<BlockCholesky::Pair> pairs_;
  BlockCholesky matrix_;
  std::vector<double> u_, gradient_, step_;  // of the bodies, with one that stands at the end
  std::vector<double> impulses_;
  std::vector<Kink> kinks_;
  std::vector<double> wants_, foreseen_;  // by how much friction's limits should change [Row::unit]
  Answered answered_[kAnswers];
  double nearest_ = 0;  // [m/s] that friction's limits were off, the least so far, by kNearer
  int slow_ = 0;        // followings since
  bool shrinks_ = false, agree_ = false;
  std::size_t steps_ = 0;
};

}  // namespace cloudcontact
