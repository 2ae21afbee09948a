// DigitalObject: a body of any digital kind (docs/method.md, "Step 1: digital objects"). Every kind
// becomes a body in Bullet as CloudShape(SurfaceField::build(toCloud(object, voxelSize))).
//
// Free functions convert between kinds; conversions that are not in the table go through the cloud.
//
//   from \ to     cloud          points          spheres           columns    octree  sphere tree
//   Mesh          digitize       -               -                 toColumns  -       -
//   Cloud         resampled      centerPoints    inscribedSpheres  toColumns  Octree  SphereTree
//                                cornerPoints
//                                surfacePoints
//   PointCloud    toCloud        -               -                 -          -       SphereTree
//   SphereCloud   toCloud        -               -                 -          -       SphereTree
//   ColumnCloud   toCloud        -               -                 -          -       -
//   Octree        cloud()        -               -                 -          -       -
//   SphereTree    toCloud        -               toSpheres         -          -       -
//   DepthImage    toCloud        toPoints        -                 -          -       -  (toMesh)
//
// Exact at the same voxelSize: octree, columns, centerPoints with perEdge 1, sphere trees of a
// cloud.
#pragma once

#include <cloudcontact/objects/depth_image.h>
#include <cloudcontact/objects/octree.h>
#include <cloudcontact/objects/point_cloud.h>
#include <cloudcontact/objects/sphere_cloud.h>
#include <cloudcontact/objects/sphere_tree.h>
#include <cloudcontact/voxels/column_cloud.h>

#include <variant>

namespace cloudcontact {

// A body of any kind.
using DigitalObject =
    std::variant<Cloud, PointCloud, SphereCloud, ColumnCloud, Octree, SphereTree, DepthImage>;

// "voxels", "points", "spheres", "columns", "octree", "sphere tree", "depth image".
const char* kindName(const DigitalObject& object);

// The object as voxels, by the kind's own toCloud() with default settings (a depth image becomes a
// shell of three voxels). Throws as that does, and std::invalid_argument for an empty object.
Cloud toCloud(const DigitalObject& object, double voxelSize);

// The cloud in voxels of another size [m]. Each voxel is divided along the surface inside it, so
// smaller voxels keep the surface smooth. The same size returns the same cloud. Throws
// std::invalid_argument where the size is not positive and finite.
Cloud resampled(const Cloud& cloud, double voxelSize);

// The spheres of a tree's leaves; cubes become spheres of equal volume.
SphereCloud toSpheres(const SphereTree& tree);

// The points of the image's pixels, as points of a surface. Throws as validate(DepthImage) does.
PointCloud toPoints(const DepthImage& image);

// The axis-aligned box around the material, in the body's frame [m]; empty for an empty object.
// Throws as validate() of the kind does.
Eigen::AlignedBox3d boundsOf(const DigitalObject& object);

// A voxel size that keeps the object's detail [m]: its own voxel size, four columns, or a hundredth
// of the diagonal; for points of a surface at least two point distances. Throws as boundsOf() does,
// and std::invalid_argument for an empty object.
double suggestedVoxel(const DigitalObject& object);

}  // namespace cloudcontact
