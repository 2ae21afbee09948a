// BlockCholesky: a sparse symmetric matrix of blocks of 6 by 6, and its Cholesky factor.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace cloudcontact {

// A row of blocks a body; a block for each two bodies that have rows in common. Bodies are
// eliminated in the order of the fewest neighbors (minimum degree), which adds no block to a chain
// or a tower and few to a heap. The sums have one order, so that results are equal on all machines.
class BlockCholesky {
 public:
  static constexpr int kSize = 6;
  using Block = std::array<double, kSize * kSize>;  // by columns
  using Pair = std::pair<int, int>;                 // of bodies, the smaller first

  // Makes it the unit matrix of so many bodies, with room for the blocks of these pairs, which are
  // sorted and differ from each other.
  void reset(int bodies, const std::vector<Pair>& pairs);
  Block& diagonal(int body) { return blocks_[static_cast<std::size_t>(body)]; }
  struct Beside {
    Block& block;
    bool swapped;  // its rows are the pair's second body's, its columns the first's
  };
  Beside beside(std::size_t pair) { return {blocks_[places_[pair].at], places_[pair].swapped}; }

  // Keeps the matrix as well. False if it is not positive definite.
  bool factor();
  // Solves for `x`, six numbers a body, with the last factor.
  void solve(double* x) const;

 private:
  using Index = std::uint32_t;
  struct Place {
    Index at;
    bool swapped;
  };
  struct Below {  // a block of a column of the factor
    Index body, at;
  };
  struct Update {  // block `to` less the product of `left` and the transpose of `right`
    Index to, left, right;
  };
  struct Column {
    Index body;
    Index below, updates;  // the ends of its own
  };
  using Sets = std::vector<std::vector<Index>>;

  Sets eliminate(Sets neighbors);
  void place(const Sets& below);
  Index firstBelow(Index column) const { return column > 0 ? columns_[column - 1].below : 0; }
  Index blockOf(Index body, Index column) const;

  int bodies_ = -1;
  std::vector<Pair> pairs_;
  std::vector<Place> places_;
  std::vector<Index> columnOf_;  // of a body
  std::vector<Column> columns_;
  std::vector<Below> below_;
  std::vector<Update> updates_;
  std::vector<Block> blocks_, factor_;  // the diagonal's, then the others
};

}  // namespace cloudcontact
