// What explains a block of voxels that no smooth surface does: two or three faces that meet in it,
// or the four to six of a tip.
#pragma once

#include "field/edge_block.h"

#include <vector>

namespace cloudcontact {

constexpr int kMostNear = 6;     // faces that a search tries in pairs and triples
constexpr int kMostAround = 10;  // and those that it chooses a tip's from
constexpr int kFewFaces = 3;  // so many are tried in all their combinations, more only all at once

// When more than three faces are tried: where fewer leave much, or, beside a known tip, already
// where they are not exact.
enum class TipsTried : std::uint8_t { Last, Soon };

// Tries combinations of faces on one block, moves the best few into place and keeps the best of
// these. Holds its memory between blocks.
class EdgeSearch {
 public:
  // `wanted` the block's coverage, `faces` those seen near it, the weightiest first (at most
  // kMostAround), `mean` the normal of the block's quadric.
  Hypothesis run(const float* wanted, const std::vector<Face>& faces, const Eigen::Vector3f& mean,
                 TipsTried tips);

 private:
  struct Trial {
    Combination faces{};
    Face plane;  // the last face, where it is sought
    float residual = 1.0f;
  };

  float residualOf(const Combination& c) const;
  void tryOne(const Combination& c);
  void sortTrials();
  void tryPairs();
  void tryTriples();
  const FaceField* spreadFaces();
  void tryTips();
  void refineBest(std::size_t most);
  void trySought(const Eigen::Vector3f& mean);
  void guess(Combination c, const Eigen::Vector3f& normal);
  void keep(const Hypothesis& h);

  const float* wanted_ = nullptr;
  int count_ = 0;
  FaceField fields_[kMostNear];
  std::vector<Face> around_;
  FaceField spread_[kMostFaces], sought_, work_[kMostFaces];
  std::vector<Trial> trials_, pairs_;
  Hypothesis best_;
};

}  // namespace cloudcontact
