// Explains a block of voxels that no smooth surface fits: two or three faces that meet in it, or
// the four to six of a tip.
#pragma once

#include "field/edge_refine.h"

#include <initializer_list>
#include <utility>
#include <vector>

namespace cloudcontact {

constexpr int kMostNear = 6;     // faces tried in pairs and triples
constexpr int kMostAround = 10;  // faces that the ones of a tip are chosen from
constexpr int kFewFaces = 3;  // up to this many are tried in all combinations, more only together

// When to try more than three faces: if fewer leave a large residual, or already if they leave any,
// beside a known tip.
enum class TipsTried : std::uint8_t { Last, Soon };

// Tries combinations of faces on one block, refines the best few and keeps the best of these.
// Reuses its memory between blocks.
class EdgeSearch {
 public:
  // `target` is the block's coverage. `faces` are those seen near the block, heaviest first, at
  // most kMostAround. `mean` is the normal of the block's quadric. An edge is useful if its
  // residual is below `bound`; the best that is not may be another than a full search would find.
  Hypothesis run(const float* target, const std::vector<Face>& faces, const Eigen::Vector3f& mean,
                 TipsTried tips, float bound);

 private:
  struct Trial {
    Combination faces{};
    Face plane;  // the last face, if hidden
    float residual = 1.0f;
  };

  struct Limits {
    float residual, miss;  // largest, of the block and of its middle voxel
  };

  Combination combineNear(std::initializer_list<int> faces, bool concave) const;
  void consider(const Combination& c, const Face& plane, float limit);
  void choose(std::size_t most, Limits limits);
  void tryPairs();
  void tryTriples();
  const FaceField* spreadFaces();
  void tryTips();
  void refineBest();
  void tryHidden(const Eigen::Vector3f& mean);
  void placeHidden(Combination c, const Eigen::Vector3f& normal);
  float placeOf(const Combination& c) const;
  void keep(const Hypothesis& h);

  const BlockTarget* target_ = nullptr;
  int count_ = 0;
  float useful_ = 0;  // residual below which a hypothesis decides what is found
  FaceField fields_[kMostNear];
  Angle angles_[kMostNear][kMostNear];  // of two fields
  std::vector<Face> around_;
  FaceField spread_[kMostEdgeFaces], hidden_, work_[kMostEdgeFaces];
  std::vector<Trial> trials_, pairs_;         // best first
  std::vector<Trial> candidates_;             // with the least residual that they may leave
  std::vector<std::pair<float, int>> order_;  // of the candidates, by that residual
  Hypothesis best_;
};

}  // namespace cloudcontact
