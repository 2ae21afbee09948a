// How deep a tool goes into a workpiece: where what the hand's spring still pushes with is what the
// material answers. Paper, Step 3: an index of the state of interaction, searched by bisection,
// by Newton's way, or in a lookup table.
#pragma once

#include <cloudcontact/law/law.h>

#include <cstdint>
#include <functional>
#include <vector>

namespace cloudcontact {

// The index of a state: the force [N] with which the two bodies resist so deep an embedding [m].
// Not falling with depth; else one of several answers is found.
using Index = std::function<double(double depth)>;

// What pushes: a spring between where the hand is and where the tool is kept.
struct HandSpring {
  double stiffness = 0;  // [N/m]; 0: nothing pushes
  double reach = 0;      // [m] how deep the tool would be if nothing held it
};

enum class Search : std::uint8_t {
  Bisection,  // halves the range: as many steps as the tolerance has bits, whatever the index
  Newton,     // follows the slope, never out of the range that still holds the answer
  Table       // looks the range up among depths evaluated beforehand, then a secant or two
};

struct EmbeddingSettings {
  Search search = Search::Newton;
  double tolerance = 1e-7;  // of the range that is searched: from nothing to the hand's reach
  int iterations = 64;      // evaluations of the index at most
  int tableEntries = 64;    // depths of Search::Table
};

enum class EmbeddingEnd : std::uint8_t {
  Found,
  NotPressed,    // the hand reaches no depth, or the index at none outdoes it: depth 0
  TooSoft,       // the index never outdoes the hand: the tool is where the hand is
  NotConverged,  // iterations ran out: the middle of what was left of the range
  NoNumber       // the index gave NaN or infinity: depth is the deepest at which it did not
};

struct Embedding {
  double depth = 0;    // d [m]
  double force = 0;    // [N] the index there
  int iterations = 0;  // evaluations of the index
  EmbeddingEnd end = EmbeddingEnd::NotPressed;
};

// Throws std::invalid_argument where a setting or the spring is negative or not finite.
Embedding embed(const Index& index, const HandSpring& hand, const EmbeddingSettings& settings = {});

// The same for a law and what it remembers, at the end of a step of `step` seconds.
Embedding embed(const Law& law, const LawState& before, double step, const HandSpring& hand,
                const EmbeddingSettings& settings = {});

// An index evaluated beforehand at evenly spaced depths: for Search::Table, where evaluating is
// dear and the same index is asked many times.
class EmbeddingTable {
 public:
  // Throws std::invalid_argument where `most` [m] is not positive or there are under 2 entries.
  EmbeddingTable(const Index& index, double most, int entries);
  double most() const { return most_; }
  double at(double depth) const;  // straight lines between the entries; the last goes on
  // As embed() with this index; `polish`, where given, is what was tabulated, and a few evaluations
  // of it bring the answer to the tolerance.
  Embedding find(const HandSpring& hand, const EmbeddingSettings& settings = {},
                 const Index& polish = {}) const;

 private:
  double most_;
  std::vector<double> force_;
};

}  // namespace cloudcontact
