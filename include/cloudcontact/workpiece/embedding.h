// How deep a tool goes into a workpiece: the embedding depth d at which the force of the hand's
// spring equals the material's. Paper, Step 3: an index of the state of interaction, searched by
// bisection, Newton's method, or in a lookup table (docs/method.md, "Step 3: embedding").
#pragma once

#include <cloudcontact/law/law.h>

#include <cstdint>
#include <functional>
#include <type_traits>
#include <utility>
#include <vector>

namespace cloudcontact {

// The index of a state: the force [N] with which the two bodies resist an embedding depth [m]. It
// must not fall with depth, or one of several solutions is found. Made from a function of the
// depth.
struct Index {
  std::function<double(double depth)> force;
  // [N/m] For Search::Newton, which takes secants where it is empty.
  std::function<double(double depth)> slope = {};

  template <typename Force,
            typename = std::enable_if_t<std::is_invocable_r_v<double, Force, double>>>
  Index(Force f) : force(std::move(f)) {}
  template <typename Force, typename Slope>
  Index(Force f, Slope g) : force(std::move(f)), slope(std::move(g)) {}
  double operator()(double depth) const { return force(depth); }
};

// What an index may depend on beside the depth (paper, Step 3).
struct Interaction {
  double depth = 0;         // d [m]
  double speed = 0;         // of the depth, over the step that ends at it [m/s]
  double acceleration = 0;  // of the depth: change of that speed over the step [m/s^2]
  double stiffness = 0;     // k of the collision, (1) [N/m]
  double damping = 0;       // c, (2) [N s/m]
  double hardness = 0;      // mean over the collision voxels [Pa]
  double ability = 0;       // of the tool to cut: mean over the collision voxels
};
using InteractionIndex = std::function<double(const Interaction&)>;  // [N]

// The spring between the hand and the tool, which pushes.
struct HandSpring {
  double stiffness = 0;  // [N/m]; 0: nothing pushes
  double reach = 0;      // depth of the tool where the hand is [m]
};

// How embed() comes to the depth at which index and hand balance.
enum class Search : std::uint8_t {
  Bisection,  // halves the range: one step per bit of the tolerance, for any index
  Newton,     // follows the index's slope, but stays in the range that brackets the solution
  Table       // brackets the solution among depths evaluated beforehand, then as Newton
};

// How a depth is searched.
struct EmbeddingSettings {
  Search search = Search::Newton;
  double tolerance = 1e-7;  // relative to the range searched, which is the hand's reach
  int iterations = 64;      // most evaluations of the index, beside those for a table
  int tableEntries = 64;    // depths of Search::Table
};

// How a search ended.
enum class EmbeddingEnd : std::uint8_t {
  Found,
  NotPressed,    // the hand is outside, or the index at depth 0 already holds it: depth 0
  TooSoft,       // the index never balances the hand: the tool is where the hand is
  NotConverged,  // out of iterations: depth is the middle of the remaining range
  NoNumber       // the index is NaN or infinite: depth is the deepest at which it is finite
};

struct Embedding {
  double depth = 0;    // d [m]
  double force = 0;    // the index there [N]
  int iterations = 0;  // evaluations of the index, those for a table included
  EmbeddingEnd end = EmbeddingEnd::NotPressed;
};

// Throws std::invalid_argument where a setting or the spring is negative or not finite.
Embedding embed(const Index& index, const HandSpring& hand, const EmbeddingSettings& settings = {});

// The same for a law and its state before, at the end of a step of `step` seconds.
Embedding embed(const Law& law, const LawState& before, double step, const HandSpring& hand,
                const EmbeddingSettings& settings = {});

// The same for an index of the state of interaction. `before`: at the end of the step before; what
// does not depend on the depth is as it is now.
Embedding embed(const InteractionIndex& index, const Interaction& before, double step,
                const HandSpring& hand, const EmbeddingSettings& settings = {});

// An index evaluated beforehand at evenly spaced depths. For Search::Table, and for an index that
// is expensive and searched many times.
class EmbeddingTable {
 public:
  EmbeddingTable() = default;  // empty until filled
  // As fill().
  EmbeddingTable(const Index& index, double most, int entries) { fill(index, most, entries); }
  // Evaluates the index `entries` times, from depth 0 to `most` [m]. Allocates only where there are
  // more entries than before. Throws std::invalid_argument where `most` is not positive or there
  // are under 2 entries.
  void fill(const Index& index, double most, int entries);
  void reserve(int entries) { force_.reserve(static_cast<std::size_t>(entries)); }
  double most() const { return most_; }  // 0 where empty
  double at(double depth) const;         // linear between entries; the last segment continues
  // As embed() with this index. `polish`, if given, is the tabulated index: a few evaluations of it
  // bring the solution to the tolerance. Only they are counted. Throws std::logic_error where the
  // table is empty.
  Embedding find(const HandSpring& hand, const EmbeddingSettings& settings = {}) const;
  Embedding find(const HandSpring& hand, const EmbeddingSettings& settings,
                 const Index& polish) const;

 private:
  struct Segment {
    double low, high;
  };
  Segment bracket(const HandSpring& hand) const;

  double most_ = 0;
  std::vector<double> force_;
};

}  // namespace cloudcontact
