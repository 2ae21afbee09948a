// The surface of a body that is cut, over time: pieces that are there for a while.
#pragma once

#include <cloudcontact/voxels/display_mesh.h>

#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "replay/shaded_mesh.h"

namespace cloudcontact::program {

struct SurfacePiece {
  double from = 0;                                      // [s] it is shown from here ...
  double to = std::numeric_limits<double>::infinity();  // ... to before here
  ShadedMesh mesh;                                      // in the matter's frame
};

// Only the bricks that a cut changes get new surface, so a replay grows by what is cut.
class ChangingSurface {
 public:
  ChangingSurface(const Cloud& matter, double time);

  // The matter at a later time, in the same grid.
  void renew(const Cloud& matter, double time);
  void end(double time);  // nothing is left
  // What came and went at the same times is one piece.
  std::vector<SurfacePiece> finish();

 private:
  struct Brick {
    double from;
    ShadedMesh mesh;
  };
  void show(const std::vector<int>& bricks, double time);
  void close(int brick, double time);

  DisplayMesh display_;
  std::map<int, Brick> shown_;  // by number
  std::map<std::pair<double, double>, ShadedMesh> pieces_;
};

}  // namespace cloudcontact::program
