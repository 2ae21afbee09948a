// PointCloud: a body as points (paper, step 1 and Fig. 2), either filling it, as the corners or
// centres of voxels do, or lying on its surface, as a scanner sees it.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <string>
#include <vector>

namespace cloudcontact {

struct PointCloud {
  std::vector<Vec3> positions;  // [m], body's frame
  // Edge of the cube that a point of share 1 stands for [m]; 0: the points lie on the surface.
  double spacing = 0;
  // One a point, or empty.
  std::vector<float> shares;             // part of its cube that is material, 0..1; empty: all 1
  std::vector<Eigen::Vector3f> normals;  // outward unit, where known
  std::vector<std::uint8_t> material;    // index into `materials`
  std::vector<std::string> materials;    // empty for one material

  bool fillsVolume() const { return spacing > 0; }
};

// Throws std::invalid_argument that names what does not hold of the above: lengths that differ, a
// number that is not finite, a share outside 0..1, a normal not of length 1, a material not there.
void validate(const PointCloud& points);

// Points at the centres of voxels with material, each with the voxel's coverage as its share; with
// perEdge > 1 at those of perEdge^3 parts of each voxel, whose shares follow the surface inside it.
// With perEdge 1 their cloud at the same voxelSize is the one they came from, to the bit. Throws
// where perEdge is not 1..16.
PointCloud centerPoints(const Cloud& cloud, int perEdge = 1);

// Points at the corners of voxels. A corner stands for the cube about it, an eighth of each of the
// voxels that meet there.
PointCloud cornerPoints(const Cloud& cloud);

// Points on the surface with their normals, perEdge^2 for a voxel's face of it.
PointCloud surfacePoints(const Cloud& cloud, int perEdge = 1, int threads = 0);

// What a scan's points are taken for. Lengths in metres; 0: found from the points.
struct ScanSettings {
  double voxelSize = 0;  // must be set
  // Holes up to twice this across are closed; walls thinner than that have no inside between their
  // points, and are told by the points' normals alone. 0: twice the points' own distance.
  double gap = 0;
  // Points within this distance are one smooth piece of surface: noise is averaged over it, edges
  // are rounded by it. 0: two and a half times the points' own distance.
  double smoothing = 0;
  // Where the points close no volume: the thickness of a shell, behind the points where they have
  // normals, to both sides of them otherwise. 0: refuse.
  double shell = 0;
  int threads = 0;  // 0: all cores
};

struct ScanReport {
  double pointDistance = 0;  // [m] between neighbours
  bool closed = false;       // an inside was found; otherwise it is a shell
  std::size_t turned = 0;    // points whose normals were found, or turned, to look outward
};

// The body that a scan's points are the surface of, of one material: what points say of theirs is
// passed over. A ball of 12 voxels' radius comes back with coverage right to 0.002 from points 1.3
// to 0.3 voxels apart. Throws std::invalid_argument where there are
// fewer than 16 points, or they close no volume and no shell is asked for; std::length_error where
// it takes too much memory.
Cloud toCloud(const PointCloud& points, const ScanSettings& settings, ScanReport* report = nullptr);

// Volume-filling points as voxels, each point's cube where it is; where voxelSize is a multiple of
// the spacing, voxels' faces lie on the cubes' faces. Points of a surface as above.
Cloud toCloud(const PointCloud& points, double voxelSize);

// The distance from a point to its fourth nearest, in the middle of all [m]: of a square lattice of
// points its edge.
double pointDistance(const PointCloud& points);

// Points without a spacing that fill a volume (those around each are spread in all directions, not
// along a surface) get one; true where they do.
bool recognizeVolume(PointCloud& points);

}  // namespace cloudcontact
