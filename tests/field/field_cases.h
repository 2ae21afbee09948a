// Solids with known signed distance, and the errors of their clouds' fields. Shared by
// surface_field_test and contact_table. All lengths in voxels.
#pragma once

#include "contact/contact_cases.h"

namespace cloudcontact::testing {

// The truth at a point of the solid's frame.
struct TrueSurface {
  double depth;   // positive inside; valid beside faces, and inside also at edges
  Vec3 normal;    // outward, of the nearest face
  double toEdge;  // distance to the nearest edge: 1e9 on a sphere
};

struct SolidCase {
  std::string name;
  std::function<Body(BodyMaker&)> make;
  std::function<TrueSurface(const Vec3&)> truth;
  Vec3 half;  // half the size of the bounds
  double area, volume;
  double radius = 1e9;  // of curvature
  double deepest = 1;   // below this depth no face is nearer than the other
  bool box = false;
};
// A case's name in gtest's messages.
void PrintTo(const SolidCase& one, std::ostream* out);
std::vector<SolidCase> solidCases();

// Errors of depth and normal [deg] at points near the surface.
struct FieldErrors {
  double depthBias = 0, depthMean = 0, depthWorst = 0, normalMean = 0, normalWorst = 0;
  int points = 0, missing = 0;  // missing: the field has no value there
};
// At points from `outermost` outside to as deep as the case allows, at distances from edges in
// [least, most), on a number of clouds.
FieldErrors fieldErrors(const SolidCase& one, double least, double most, double outermost,
                        int clouds, const BodyMaker& settings);

// The worst errors of a field about the side of a point, up to 4 voxels from the solid's bounds:
// the largest depth outside, and the least depth inside down to `deepest`.
struct FieldSides {
  double falseOverlap = -1e9, falseGap = 1e9;
  int outside = 0, inside = 0;            // points at which the field has a value
  int falseOutside = 0, falseInside = 0;  // beyond kSideSlack on the wrong side
};
constexpr double kSideSlack = 0.1;
FieldSides fieldSides(const SolidCase& one, int clouds, const BodyMaker& settings);

// Sums over all samples of a cloud, in the solid's frame.
struct SampleSums {
  double area = 0;
  double volume = 0;  // by the divergence theorem
  Vec3 vectorArea = Vec3::Zero();
  double offMean = 0, offWorst = 0;  // distance from the true surface
  double normalMean = 0;             // [deg], more than a voxel from edges
  // Beside a box's edges: relative error of the integral of max(0, d - distance to the edge) along
  // each side of each edge, at d = 0.5 and 1. This is the force of a wall pressed in by d.
  double stripMean[2] = {}, stripWorst[2] = {};
};
SampleSums sampleSums(const SolidCase& one, const Body& body);

}  // namespace cloudcontact::testing
