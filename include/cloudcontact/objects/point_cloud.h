// PointCloud: a body as points (paper, step 1 and Fig. 2). The points fill its volume, as corners
// or centers of voxels do, or lie on its surface, as those of a scanner do.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <string>
#include <vector>

namespace cloudcontact {

struct PointCloud {
  std::vector<Vec3> positions;  // [m], body's frame
  // Edge of the cube that a point represents [m]; 0: the points lie on the surface.
  double spacing = 0;
  // One per point, or empty.
  std::vector<float> shares;             // fraction of the cube that is material, 0..1; empty: 1
  std::vector<Eigen::Vector3f> normals;  // outward unit, where known
  std::vector<std::uint8_t> material;    // index into `materials`
  std::vector<std::string> materials;    // empty for one material

  bool fillsVolume() const { return spacing > 0; }
};

// Throws std::invalid_argument that names the fault: lengths that differ, a number that is not
// finite, a share outside 0..1, a normal that is not of length 1, an index without a material.
void validate(const PointCloud& points);

// Points at the centers of voxels with material, with the voxels' coverages as shares. With
// perEdge > 1 each voxel is divided into perEdge^3 parts, whose shares follow the surface inside
// it. With perEdge 1 toCloud() at the same voxelSize gives the cloud back to the bit. Throws
// std::invalid_argument where perEdge is not 1..16.
PointCloud centerPoints(const Cloud& cloud, int perEdge = 1);

// Points at the corners of voxels. A corner represents the cube around it, an eighth of each of the
// voxels that meet there.
PointCloud cornerPoints(const Cloud& cloud);

// Points on the surface with normals, about perEdge^2 per voxel face. Throws std::invalid_argument
// where perEdge is not 1..16.
PointCloud surfacePoints(const Cloud& cloud, int perEdge = 1, int threads = 0);

// How points of a surface become a body. Lengths in meters; 0: derived from the points.
struct ScanSettings {
  double voxelSize = 0;  // must be set
  // Holes up to twice this wide are closed. In walls thinner than that the flood finds no inside,
  // and the points' normals alone decide. 0: twice the point distance.
  double gap = 0;
  // Radius of the smooth pieces fitted to the points. Noise is averaged over it, and edges are
  // rounded by it. 0: two and a half times the point distance.
  double smoothing = 0;
  // Thickness of the shell for points that close no volume. It lies behind the points where they
  // have normals, and on both sides otherwise. 0: such points are refused.
  double shell = 0;
  int threads = 0;  // 0: all cores
};

// What toCloud() found of a scan.
struct ScanReport {
  double pointDistance = 0;  // between neighbors [m]
  bool closed = false;       // the points close a volume; otherwise the body is a shell
  std::size_t turned = 0;    // normals reversed to point outward
};

// The body under the points of a surface. It is of one material; those of the points are ignored.
// For a ball of 12 voxels radius and points 0.3 to 1.3 voxels apart, coverage is right to 0.002.
// Throws std::invalid_argument where there are fewer than 16 points, or where they close no volume
// and settings.shell is 0; std::length_error where the voxels or the flood would need too much
// memory.
Cloud toCloud(const PointCloud& points, const ScanSettings& settings, ScanReport* report = nullptr);

// Points that fill a volume as voxels: the union of their cubes. Where voxelSize is a multiple of
// the spacing, faces of voxels lie on faces of cubes. Points of a surface as above, with default
// settings.
Cloud toCloud(const PointCloud& points, double voxelSize);

// The median distance of a point to its fourth nearest [m]: the edge of a square lattice of points.
double pointDistance(const PointCloud& points);

// Sets the spacing of points that fill a volume (their neighbors spread in all directions, not
// along a surface). Returns whether the points fill a volume.
bool recognizeVolume(PointCloud& points);

}  // namespace cloudcontact
