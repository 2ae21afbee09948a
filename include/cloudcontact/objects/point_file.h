// Points from files: PLY without faces, PCD (text and binary) and XYZ.
// Part of the target CloudContact::files.
#pragma once

#include <cloudcontact/objects/depth_image.h>
#include <cloudcontact/objects/point_cloud.h>

#include <filesystem>
#include <variant>

namespace cloudcontact {

// A PCD of several rows is what a depth camera saw, hole and all; everything else is points.
using PointFile = std::variant<PointCloud, DepthImage>;

// Whether the file is one of points: a .pcd or .xyz, or a .ply whose header names vertices and no
// faces. False where it cannot be read.
bool isPointFile(const std::filesystem::path& file);

// In metres: file coordinates times `metresPerUnit`. Normals are read where they are (PLY nx ny nz,
// PCD normal_x .., XYZ columns 4 to 6 where each row's are of length 1), other fields are passed
// over. Whether points fill a volume no format says: recognizeVolume() asks the points themselves.
// Throws std::runtime_error that names the file and says what is wrong: it is missing, empty, of
// none of these formats, cut short, has no x, y and z, no points, or a NaN or infinite one (a NaN
// in a PCD of several rows is a hole).
PointFile loadPoints(const std::filesystem::path& file, double metresPerUnit = 1.0);

}  // namespace cloudcontact
