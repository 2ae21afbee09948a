// Points from files: PLY without faces, PCD (text and binary) and XYZ.
// Part of the target CloudContact::files.
#pragma once

#include <cloudcontact/objects/depth_image.h>
#include <cloudcontact/objects/point_cloud.h>

#include <filesystem>
#include <variant>

namespace cloudcontact {

// A PCD of several rows is the image of a depth camera, with its holes; other files are points.
using PointFile = std::variant<PointCloud, DepthImage>;

// Whether a file holds points: a .pcd or .xyz, or a .ply whose header has vertices and no faces.
// False where the file cannot be read.
bool isPointFile(const std::filesystem::path& file);

// The points of a file. Coordinates are multiplied by `metersPerUnit`. Normals are read (PLY nx ny
// nz, PCD normal_x .., XYZ columns 4 to 6 if they are of length 1 in every row), other fields
// ignored. No format states whether points fill a volume: see recognizeVolume(). Throws
// std::runtime_error that names the file and the fault: missing, empty, of another format, cut
// short, without x, y and z, without points, or with a NaN or infinite point (a NaN in a PCD of
// several rows is a hole).
PointFile loadPoints(const std::filesystem::path& file, double metersPerUnit = 1.0);

}  // namespace cloudcontact
