// How deep a tool goes into a workpiece: the embedding depth d at which the force of the hand's
// spring equals the material's. Paper, Step 3: an index of the state of interaction, searched by
// bisection, Newton's method, or in a lookup table (docs/method.md, "Step 3: embedding").
#pragma once

#include <cloudcontact/law/law.h>

#include <cstdint>
#include <functional>
#include <vector>

namespace cloudcontact {

// The index of a state: the force [N] with which the two bodies resist an embedding depth [m]. It
// must not fall with depth, or one of several solutions is found.
using Index = std::function<double(double depth)>;

// The spring between the hand and the tool, which pushes.
struct HandSpring {
  double stiffness = 0;  // [N/m]; 0: nothing pushes
  double reach = 0;      // depth of the tool where the hand is [m]
};

enum class Search : std::uint8_t {
  Bisection,  // halves the range: one step per bit of the tolerance, for any index
  Newton,     // follows the slope, but stays in the range that brackets the solution
  Table       // brackets the solution among depths evaluated beforehand, then takes secants
};

struct EmbeddingSettings {
  Search search = Search::Newton;
  double tolerance = 1e-7;  // relative to the range searched, which is the hand's reach
  int iterations = 64;      // most evaluations of the index
  int tableEntries = 64;    // depths of Search::Table
};

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
  int iterations = 0;  // evaluations of the index
  EmbeddingEnd end = EmbeddingEnd::NotPressed;
};

// Throws std::invalid_argument where a setting or the spring is negative or not finite.
Embedding embed(const Index& index, const HandSpring& hand, const EmbeddingSettings& settings = {});

// The same for a law and its state before, at the end of a step of `step` seconds.
Embedding embed(const Law& law, const LawState& before, double step, const HandSpring& hand,
                const EmbeddingSettings& settings = {});

// An index evaluated beforehand at evenly spaced depths. For Search::Table, and for an index that
// is expensive and searched many times.
class EmbeddingTable {
 public:
  // Throws std::invalid_argument where `most` [m] is not positive or there are under 2 entries.
  EmbeddingTable(const Index& index, double most, int entries);
  double most() const { return most_; }
  double at(double depth) const;  // linear between entries; the last segment continues
  // As embed() with this index. `polish`, if given, is the tabulated index: a few evaluations of it
  // bring the solution to the tolerance.
  Embedding find(const HandSpring& hand, const EmbeddingSettings& settings = {},
                 const Index& polish = {}) const;

 private:
  double most_;
  std::vector<double> force_;
};

}  // namespace cloudcontact
