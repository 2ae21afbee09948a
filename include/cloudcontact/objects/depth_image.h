// DepthImage: what a depth camera sees, a point for each of its pixels (paper, I), and how it
// becomes a surface and a body.
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>

#include <vector>

namespace cloudcontact {

struct DepthImage {
  int width = 0, height = 0;      // pixels
  std::vector<Vec3> points;       // [m] row by row, width * height; NaN where nothing was seen
  Vec3 viewpoint = Vec3::Zero();  // [m] where the camera stands
};

// Throws std::invalid_argument where the points are not width * height, one is infinite, fewer than
// three are there, or one lies on the viewpoint.
void validate(const DepthImage& image);

struct DepthSettings {
  // Neighbour pixels are one surface where their distances from the camera differ by less [m].
  // 0: six times the distance of neighbours, that in the middle of all. Noise should stay under a
  // sixth of it, steps that are to stay open above it.
  double jump = 0;
  // Holes of at most so many pixels are filled by the quadratic through their rim, where the rim is
  // one surface. 0: none.
  int holePixels = 30;
  // Each pixel's distance becomes that of the quadratic through the pixels of its surface up to
  // this many columns and rows away. Noise shrinks to 0.45, 0.31, 0.24 of itself at 2, 3, 4;
  // creases are rounded over as many pixels, steps are not crossed. 0: none.
  int smoothing = 3;
  int threads = 0;  // 0: all cores
};

struct DepthReport {
  double jump = 0;         // [m] that was used
  std::size_t seen = 0;    // pixels with a point
  std::size_t filled = 0;  // pixels filled
  std::size_t left = 0;    // holes that stayed open, in pixels
};

// Holes filled, noise smoothed.
DepthImage mended(const DepthImage& image, const DepthSettings& settings = {},
                  DepthReport* report = nullptr);

// Neighbouring pixels joined to triangles that look at the camera, except across jumps. The image
// as it is: mend it first. Vertices are those of the pixels that triangles use.
Mesh toMesh(const DepthImage& image, const DepthSettings& settings = {});

enum class Backing {
  Shell,  // a sheet as thick as asked, along the surface's normals
  Rays    // closed as far behind the surface as asked, away from the camera
};

struct DepthCloudSettings {
  double voxelSize = 0;  // [m], must be set
  double thickness = 0;  // [m]; 0: three voxels
  Backing backing = Backing::Shell;
  DepthSettings image;
};

// Mended, joined, backed and digitised. Throws as the above and as digitize does.
Cloud toCloud(const DepthImage& image, const DepthCloudSettings& settings,
              DepthReport* report = nullptr);

}  // namespace cloudcontact
