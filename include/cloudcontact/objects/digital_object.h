// DigitalObject: a body in any of the digital kinds of the paper's step 1. Any of them can be a
// body in Bullet by way of its cloud: CloudShape(SurfaceField::build(toCloud(object, voxelSize))).
//
// Free functions lead from kind to kind; what is not in the table goes by way of the cloud.
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
// Exact at the same voxelSize: octree, columns, centerPoints with perEdge 1, trees of a cloud.
#pragma once

#include <cloudcontact/objects/depth_image.h>
#include <cloudcontact/objects/octree.h>
#include <cloudcontact/objects/point_cloud.h>
#include <cloudcontact/objects/sphere_cloud.h>
#include <cloudcontact/objects/sphere_tree.h>
#include <cloudcontact/voxels/column_cloud.h>

#include <variant>

namespace cloudcontact {

using DigitalObject =
    std::variant<Cloud, PointCloud, SphereCloud, ColumnCloud, Octree, SphereTree, DepthImage>;

// "voxels", "points", "spheres", "columns", "octree", "sphere tree", "depth image".
const char* kindName(const DigitalObject& object);

// The object as voxels: as the kind's own toCloud with its defaults (a scan closed by a flood, a
// depth image as a shell of three voxels). Throws as that does, and std::invalid_argument for an
// object without anything in it.
Cloud toCloud(const DigitalObject& object, double voxelSize);

// A cloud in voxels of another size: each of its voxels divided along the surface inside it, so
// that little is lost where they get smaller, and nothing but detail where they get larger. The
// same size gives the same cloud.
Cloud resampled(const Cloud& cloud, double voxelSize);

// The spheres of a tree's leaves; cubes become the spheres of their volume.
SphereCloud toSpheres(const SphereTree& tree);

// The pixels that saw something, as points of a surface.
PointCloud toPoints(const DepthImage& image);

// Lowest and highest corner of what is there [m], body's frame; empty where nothing is. Throws as
// the kind's own check.
Eigen::AlignedBox3d boundsOf(const DigitalObject& object);

// A voxel that shows what the object holds [m]: its own, where it has one; for points, spheres and
// images a hundredth of the diagonal, but not less than two point distances.
double suggestedVoxel(const DigitalObject& object);

}  // namespace cloudcontact
