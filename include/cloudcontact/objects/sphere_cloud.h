// SphereCloud: a body as the union of spheres (paper, step 1).
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <string>
#include <vector>

namespace cloudcontact {

struct SphereCloud {
  std::vector<Vec3> centers;  // [m], body's frame
  std::vector<double> radii;  // [m], one a centre
  std::vector<std::uint8_t>
      material;  // index into `materials`, one a centre; empty for one material
  std::vector<std::string> materials;
};

// Throws std::invalid_argument that names what does not hold of the above: lengths that differ, a
// radius that is not positive, a number that is not finite, a material that is not there.
void validate(const SphereCloud& spheres);

// Voxels of the union. A voxel that surfaces pass through is divided in 4x4x4, each part cut by the
// sphere it lies deepest in: coverage to 1/255 where one sphere's surface passes, to 0.01 where
// several meet. Throws as check, and std::length_error where it takes too much memory.
Cloud toCloud(const SphereCloud& spheres, double voxelSize, int threads = 0);

struct InscribedSettings {
  // How far the spheres' union may stay under the body's surface [voxels]. A flat face takes one
  // sphere of radius r for each disc of radius sqrt(2 r tolerance): half the tolerance, twice the
  // spheres. A nut of 24 voxels across takes 840 at 0.2, 2,900 at 0.05, 5,300 at 0.02.
  double tolerance = 0.05;
  // Radius [voxels]. At sharp edges spheres of it reach beyond the surface, by half of it at most.
  double smallest = 0.5;
  int perVoxel = 2;  // places asked along a voxel's edge of the surface, 1..8
  int threads = 0;   // 0: all cores
};

struct InscribedReport {
  // How far the surface lies outside the union, at the places asked [m].
  double meanGap = 0, worstGap = 0;
  // How far the union reaches beyond the surface at most [m].
  double worstOverlap = 0;
};

// Spheres that touch the surface from within, the largest there are at each place; of them as many
// as the tolerance asks for. One ball gives one sphere. Throws std::invalid_argument on a bad
// setting or a cloud without a surface.
SphereCloud inscribedSpheres(const Cloud& cloud, const InscribedSettings& settings = {},
                             InscribedReport* report = nullptr);

}  // namespace cloudcontact
