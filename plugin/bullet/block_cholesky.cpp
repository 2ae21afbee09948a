// Order, places, factor, solution.
#include "bullet/block_cholesky.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace cloudcontact {

namespace {

constexpr int kSize = BlockCholesky::kSize;
using Block = BlockCholesky::Block;

// In place of its lower half.
bool factorOne(Block& a) {
  for (int k = 0; k < kSize; ++k) {
    double* const column = &a[kSize * k];
    if (!(column[k] > 0)) return false;
    const double by = 1 / std::sqrt(column[k]);
    for (int i = k; i < kSize; ++i) column[i] *= by;
    for (int j = k + 1; j < kSize; ++j)
      for (int i = j; i < kSize; ++i) a[kSize * j + i] -= column[i] * column[j];
  }
  return true;
}

// Times the inverse of the factor's transpose.
void divide(Block& a, const Block& factor) {
  for (int k = 0; k < kSize; ++k) {
    double* const column = &a[kSize * k];
    const double by = 1 / factor[kSize * k + k];
    for (int i = 0; i < kSize; ++i) column[i] *= by;
    for (int j = k + 1; j < kSize; ++j)
      for (int i = 0; i < kSize; ++i) a[kSize * j + i] -= column[i] * factor[kSize * k + j];
  }
}

void subtractProduct(Block& to, const Block& left, const Block& right) {
  for (int j = 0; j < kSize; ++j) {
    double sum[kSize];
    for (int i = 0; i < kSize; ++i) sum[i] = to[kSize * j + i];
    for (int k = 0; k < kSize; ++k)
      for (int i = 0; i < kSize; ++i) sum[i] -= left[kSize * k + i] * right[kSize * k + j];
    for (int i = 0; i < kSize; ++i) to[kSize * j + i] = sum[i];
  }
}

}  // namespace

void BlockCholesky::reset(int bodies, const std::vector<Pair>& pairs) {
  if (bodies != bodies_ || pairs != pairs_) {
    bodies_ = bodies;
    pairs_ = pairs;
    Sets neighbors(static_cast<std::size_t>(bodies));
    for (const auto& [a, b] : pairs) {
      neighbors[static_cast<std::size_t>(a)].push_back(static_cast<Index>(b));
      neighbors[static_cast<std::size_t>(b)].push_back(static_cast<Index>(a));
    }
    for (std::vector<Index>& own : neighbors) std::sort(own.begin(), own.end());
    place(eliminate(std::move(neighbors)));
  }
  for (Block& block : blocks_) block.fill(0);
  for (int body = 0; body < bodies; ++body)
    for (std::size_t k = 0; k < kSize; ++k) diagonal(body)[kSize * k + k] = 1;
}

// Of each column, the bodies that are eliminated later and have a block in it. The neighbors of an
// eliminated body are neighbors of each other from then on.
BlockCholesky::Sets BlockCholesky::eliminate(Sets neighbors) {
  const std::size_t count = neighbors.size();
  Sets below;
  columns_.clear();
  columnOf_.assign(count, static_cast<Index>(count));  // none yet
  std::vector<Index> merged;
  for (std::size_t step = 0; step < count; ++step) {
    std::size_t best = count;
    for (std::size_t i = 0; i < count; ++i)
      if (columnOf_[i] == count && (best == count || neighbors[i].size() < neighbors[best].size()))
        best = i;
    const auto body = static_cast<Index>(best);
    columnOf_[best] = static_cast<Index>(step);
    columns_.push_back({body, 0, 0});
    below.push_back(std::move(neighbors[best]));
    for (const Index i : below.back()) {
      merged.clear();
      std::set_union(neighbors[i].begin(), neighbors[i].end(), below.back().begin(),
                     below.back().end(), std::back_inserter(merged));
      std::erase_if(merged, [&](Index n) { return n == i || n == body; });
      neighbors[i].swap(merged);
    }
  }
  for (std::vector<Index>& bodies : below)
    std::sort(bodies.begin(), bodies.end(),
              [&](Index a, Index b) { return columnOf_[a] < columnOf_[b]; });
  return below;
}

BlockCholesky::Index BlockCholesky::blockOf(Index body, Index column) const {
  const auto begin = below_.begin() + firstBelow(column),
             end = below_.begin() + columns_[column].below;
  return std::lower_bound(begin, end, columnOf_[body],
                          [&](const Below& b, Index wanted) { return columnOf_[b.body] < wanted; })
      ->at;
}

// Numbers the blocks, and lists what each column takes from later ones.
void BlockCholesky::place(const Sets& below) {
  below_.clear();
  updates_.clear();
  places_.clear();
  auto blocks = static_cast<Index>(below.size());
  for (std::size_t c = 0; c < below.size(); ++c) {
    for (const Index body : below[c]) below_.push_back({body, blocks++});
    columns_[c].below = static_cast<Index>(below_.size());
  }
  for (Index c = 0; c < columns_.size(); ++c) {
    const auto end = below_.begin() + columns_[c].below;
    for (auto right = below_.begin() + firstBelow(c); right != end; ++right)
      for (auto left = right; left != end; ++left)
        updates_.push_back(
            {left == right ? left->body : blockOf(left->body, columnOf_[right->body]), left->at,
             right->at});
    columns_[c].updates = static_cast<Index>(updates_.size());
  }
  for (const auto& [a, b] : pairs_) {
    const auto first = static_cast<Index>(a), second = static_cast<Index>(b);
    const bool swapped = columnOf_[first] < columnOf_[second];
    places_.push_back(
        {swapped ? blockOf(second, columnOf_[first]) : blockOf(first, columnOf_[second]), swapped});
  }
  blocks_.resize(blocks);
}

bool BlockCholesky::factor() {
  factor_ = blocks_;
  Index below = 0, update = 0;
  for (const Column& column : columns_) {
    Block& own = factor_[column.body];
    if (!factorOne(own)) return false;
    for (; below < column.below; ++below) divide(factor_[below_[below].at], own);
    for (; update < column.updates; ++update) {
      const Update& u = updates_[update];
      subtractProduct(factor_[u.to], factor_[u.left], factor_[u.right]);
    }
  }
  return true;
}

void BlockCholesky::solve(double* x) const {
  for (Index c = 0; c < columns_.size(); ++c) {
    const Block& own = factor_[columns_[c].body];
    double* const at = x + kSize * columns_[c].body;
    for (int k = 0; k < kSize; ++k) {
      at[k] /= own[kSize * k + k];
      for (int i = k + 1; i < kSize; ++i) at[i] -= own[kSize * k + i] * at[k];
    }
    for (Index b = firstBelow(c); b < columns_[c].below; ++b) {
      double* const to = x + kSize * below_[b].body;
      const Block& block = factor_[below_[b].at];
      for (int k = 0; k < kSize; ++k)
        for (int i = 0; i < kSize; ++i) to[i] -= block[kSize * k + i] * at[k];
    }
  }
  for (auto c = static_cast<Index>(columns_.size()); c-- > 0;) {
    const Block& own = factor_[columns_[c].body];
    double* const at = x + kSize * columns_[c].body;
    for (Index b = firstBelow(c); b < columns_[c].below; ++b) {
      const double* const from = x + kSize * below_[b].body;
      const Block& block = factor_[below_[b].at];
      for (int k = 0; k < kSize; ++k)
        for (int i = 0; i < kSize; ++i) at[k] -= block[kSize * k + i] * from[i];
    }
    for (int k = kSize; k-- > 0;) {
      for (int i = k + 1; i < kSize; ++i) at[k] -= own[kSize * k + i] * at[i];
      at[k] /= own[kSize * k + k];
    }
  }
}

}  // namespace cloudcontact
