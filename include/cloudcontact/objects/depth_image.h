// DepthImage: the view of a depth camera, a point for each pixel (paper, section I), and its way to
// a surface and a body.
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>

#include <vector>

namespace cloudcontact {

struct DepthImage {
  int width = 0, height = 0;      // pixels
  std::vector<Vec3> points;       // row by row, width * height [m]; NaN where nothing was seen
  Vec3 viewpoint = Vec3::Zero();  // position of the camera [m]
};

// Throws std::invalid_argument where the points are not width * height, one is infinite or lies on
// the viewpoint, or fewer than three pixels have one.
void validate(const DepthImage& image);

// How a picture becomes a surface.
struct DepthSettings {
  // Neighboring pixels are of one surface where their distances from the camera differ by less than
  // this [m]. Choose it above six times the noise and below the steps that must stay open. 0: six
  // times the median distance of neighboring points.
  double jump = 0;
  // Holes of at most this many pixels are filled by the quadratic through their rim, if the rim is
  // one surface. 0: none are filled.
  int holePixels = 30;
  // Radius in pixels of the quadratic fit that smooths each pixel's distance. The fit stays within
  // one surface. A radius of 2, 3, 4 reduces noise to 0.45, 0.31, 0.24 and rounds creases over that
  // many pixels. 0: no smoothing.
  int smoothing = 3;
  int threads = 0;  // 0: all cores
};

// What mended() found and did.
struct DepthReport {
  double jump = 0;         // the jump that was used [m]
  std::size_t seen = 0;    // pixels with a point
  std::size_t filled = 0;  // pixels filled in holes
  std::size_t left = 0;    // pixels of holes that stay open
};

// The image with holes filled and noise smoothed. Throws std::invalid_argument on a bad setting or
// image.
DepthImage mended(const DepthImage& image, const DepthSettings& settings = {},
                  DepthReport* report = nullptr);

// Triangles between neighboring pixels, facing the camera, except across jumps. Call mended()
// first: this takes the image as it is. Throws as mended() does.
Mesh toMesh(const DepthImage& image, const DepthSettings& settings = {});

// Where the back of the body lies, `thickness` behind the surface.
enum class Backing {
  Shell,  // along the surface's normals
  Rays    // along the rays of the camera
};

// How a picture becomes a body.
struct DepthCloudSettings {
  double voxelSize = 0;  // [m], must be set
  double thickness = 0;  // of the body [m]; 0: three voxels
  Backing backing = Backing::Shell;
  DepthSettings image;
};

// The image as a body: mended(), toMesh(), a back, digitize(). Throws as these do.
Cloud toCloud(const DepthImage& image, const DepthCloudSettings& settings,
              DepthReport* report = nullptr);

}  // namespace cloudcontact
