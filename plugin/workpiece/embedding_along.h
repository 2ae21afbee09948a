// How deep a solid goes into a surface along a direction (paper, Step 3: the amount of embedding).
// The depth is the greatest length of the solid below the surface, over all lines along the
// direction: how far the solid must move along it to come out. It is right for solids of any shape,
// and in a hole that the solid has cut, where all lines are as long.
//
// The surface is known by pieces of it, which may come from voxels or from samples of a surface.
#pragma once

#include <cloudcontact/law/solid.h>

#include <functional>
#include <memory>
#include <span>

namespace cloudcontact {

// A plane piece of a surface, about `EmbeddingQuery::spacing` wide.
struct PlanePiece {
  Vec3 at = Vec3::Zero();       // its middle [m]
  Vec3 outward = Vec3::Zero();  // unit normal
  double area = 1;              // [spacing^2]
};

// All in the frame of the owner of `area`.
struct EmbeddingQuery {
  const PlacedSolid* area = nullptr;  // D
  Vec3 outward = Vec3::Zero();        // unit: the way out of the surface, the digital normal
  double spacing = 0;                 // between pieces [m]
  // The share of matter, 0 to 1, that the surface's body has about a point, as in its voxel. It
  // tells walls and rims of a hole that D fills from material that D goes into, and finds the tip
  // of a leaning tool, below material beside the pieces. Empty: all that is in D counts.
  std::function<double(const Vec3&)> matter = {};
  int threads = 1;  // the result does not depend on them, to the bit
};

// Keeps its memory: allocates only where there are more pieces than in any call before.
class EmbeddingAlong {
 public:
  EmbeddingAlong();
  ~EmbeddingAlong();
  EmbeddingAlong(EmbeddingAlong&&) noexcept;
  EmbeddingAlong& operator=(EmbeddingAlong&&) noexcept;

  // The depth [m]; 0 where no piece is in D or `outward` is zero. Pieces up to kReach of a spacing
  // outside D may hold a part of it, if D is thin; others may be left out.
  double find(const EmbeddingQuery& query, std::span<const PlanePiece> pieces);
  void reserve(std::size_t pieces);

  static constexpr double kReach = 0.75;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
