// SphereCloud: a body as the union of spheres (paper, step 1).
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <string>
#include <vector>

namespace cloudcontact {

struct SphereCloud {
  std::vector<Vec3> centers;  // [m], body's frame
  std::vector<double> radii;  // [m], one per center
  std::vector<std::uint8_t>
      material;  // index into `materials`, one per center; empty for one material
  std::vector<std::string> materials;
};

// Throws std::invalid_argument that names the fault: lengths that differ, a radius that is not
// positive, a number that is not finite, an index without a material.
void validate(const SphereCloud& spheres);

// The voxels of the union. A voxel that the surface crosses is divided into 4x4x4 parts, each cut
// by the sphere that it lies deepest in: coverage is right to 1/255 where the surface of one sphere
// passes, to 0.01 where several meet. Throws as validate() does, and std::length_error where the
// voxels would need too much memory.
Cloud toCloud(const SphereCloud& spheres, double voxelSize, int threads = 0);

// How closely spheres fill a body.
struct InscribedSettings {
  // Largest gap between the union of the spheres and the surface of the body [voxels]. A flat face
  // needs one sphere of radius r per disc of radius sqrt(2 r tolerance), so half the tolerance
  // takes twice the spheres: a nut of 24 voxels takes 840 at 0.2, 2,900 at 0.05 and 5,300 at 0.02.
  double tolerance = 0.05;
  // Smallest radius [voxels]. At sharp edges such spheres overlap the surface by up to half of it.
  double smallest = 0.5;
  int perVoxel = 2;  // samples of the surface along a voxel's edge, 1..8
  int threads = 0;   // 0: all cores
};

// How far inscribed spheres are from the body.
struct InscribedReport {
  // Distance of the samples of the surface to the union [m].
  double meanGap = 0, worstGap = 0;
  // Largest distance of the union beyond the surface [m].
  double worstOverlap = 0;
};

// Inscribed spheres: the largest that touch the surface from inside at each sample, and of these as
// many as the tolerance requires. A ball gives one sphere. Throws std::invalid_argument on a bad
// setting or a cloud without a surface.
SphereCloud inscribedSpheres(const Cloud& cloud, const InscribedSettings& settings = {},
                             InscribedReport* report = nullptr);

}  // namespace cloudcontact
