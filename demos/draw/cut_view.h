// A plane through bodies and its projection onto the drawing, and the voxels and surfaces that it
// cuts.
#pragma once

#include <vector>

#include "draw/contact_scene.h"
#include "draw/drawing.h"

namespace cloudcontact::program {

struct CutView {
  Vec3 origin = Vec3::Zero();                      // shown at the frame's center, world [m]
  Vec3 right = Vec3::UnitX(), up = Vec3::UnitY();  // directions of the drawing in the world, unit
  Rectangle frame;                                 // [px]
  double scale = 1;                                // [px/m]

  Vec3 across() const { return right.cross(up); }  // toward the viewer
  double distance(const Vec3& world) const { return across().dot(world - origin); }
  // Projects a direction onto the drawing; keeps its length in the plane.
  Point direction(const Vec3& v) const { return {right.dot(v), -up.dot(v)}; }
  Point toPaper(const Vec3& world) const {
    return frame.center() + scale * direction(world - origin);
  }
  Vec3 toWorld(const Point& paper) const {
    const Point p = (paper - frame.center()) / scale;
    return origin + p.x() * right - p.y() * up;
  }
};

// A view of the plane through `origin` with the normal `across`, with z upward in the drawing if
// possible (else y).
CutView viewAcross(const Vec3& origin, const Vec3& across, const Rectangle& frame, double scale);

struct CutVoxel {
  Eigen::Vector3i voxel;
  std::uint8_t coverage;       // never 0
  Vec3 center;                 // world [m]
  std::vector<Point> outline;  // of its section, in the drawing
};

// The voxels with material that the plane cuts within the frame.
std::vector<CutVoxel> cutVoxels(const Cloud& cloud, const Pose& pose, const CutView& view);

// Pieces of the line in which the plane cuts the field's surface.
std::vector<std::vector<Point>> surfaceLines(const PictureBody& body, const CutView& view,
                                             double spacing);

// The section of one material as stripes `stripe` px high, for small views.
std::vector<std::vector<Point>> materialStripes(const PictureBody& body, const CutView& view,
                                                double stripe, int material);

}  // namespace cloudcontact::program
