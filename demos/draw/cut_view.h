// A plane through bodies and the paper it is shown on: where things of the world come to lie in a
// picture, and what the plane meets of voxels and surfaces.
#pragma once

#include <vector>

#include "draw/contact_scene.h"
#include "draw/drawing.h"

namespace cloudcontact::program {

struct CutView {
  Vec3 origin = Vec3::Zero();                      // shown at the frame's centre, world [m]
  Vec3 right = Vec3::UnitX(), up = Vec3::UnitY();  // of the paper, in the world, unit
  Rectangle frame;                                 // [px]
  double scale = 1;                                // [px/m]

  Vec3 across() const { return right.cross(up); }  // toward who looks
  double distance(const Vec3& world) const { return across().dot(world - origin); }
  // A direction's part in the plane, on paper, with its length.
  Point direction(const Vec3& v) const { return {right.dot(v), -up.dot(v)}; }
  Point toPaper(const Vec3& world) const {
    return frame.center() + scale * direction(world - origin);
  }
  Vec3 toWorld(const Point& paper) const {
    const Point p = (paper - frame.center()) / scale;
    return origin + p.x() * right - p.y() * up;
  }
};

// A view of the plane through `origin` across `across`, z upward on paper where it can be (else y).
CutView viewAcross(const Vec3& origin, const Vec3& across, const Rectangle& frame, double scale);

struct CutVoxel {
  Eigen::Vector3i voxel;
  std::uint8_t coverage;       // never 0
  Vec3 center;                 // world [m]
  std::vector<Point> outline;  // where the plane cuts it, on paper
};

// The voxels with material that the plane meets within the frame.
std::vector<CutVoxel> cutVoxels(const Cloud& cloud, const Pose& pose, const CutView& view);

// Pieces of the line in which the plane cuts the body's surface, as the field knows it.
std::vector<std::vector<Point>> surfaceLines(const PictureBody& body, const CutView& view,
                                             double spacing);

// One of the body's materials in the plane as stripes `stripe` px high: for small views.
std::vector<std::vector<Point>> materialStripes(const PictureBody& body, const CutView& view,
                                                double stripe, int material);

}  // namespace cloudcontact::program
