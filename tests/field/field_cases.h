// Solids whose signed distance is known, and how far the field of a cloud of them is from it.
// Shared by surface_field_test and contact_table. Lengths in voxels throughout.
#pragma once

#include "contact/contact_cases.h"

namespace cloudcontact::testing {

// What is true at a point of the solid's frame.
struct TrueSurface {
  double depth;   // positive inside; beside faces, and inside at edges too
  Vec3 normal;    // outward, of the nearest face
  double toEdge;  // distance to the nearest edge: 1e9 on a sphere
};

struct SolidCase {
  std::string name;
  std::function<Body(BodyMaker&)> make;
  std::function<TrueSurface(const Vec3&)> truth;
  Vec3 half;  // of the bounds
  double area, volume;
  double radius = 1e9;  // of curvature
  double deepest = 1;   // below this depth no face is nearer than the other
  bool box = false;
};
// How gtest names a case in a failure.
void PrintTo(const SolidCase& one, std::ostream* out);
std::vector<SolidCase> solidCases();

// Of depth and normal [deg] at points near the surface.
struct FieldErrors {
  double depthBias = 0, depthMean = 0, depthWorst = 0, normalMean = 0, normalWorst = 0;
  int points = 0, missing = 0;  // missing: the field knows nothing there
};
// At points as deep as the case allows and `outermost` outside, whose distance from edges is in
// [least, most), on a number of clouds.
FieldErrors fieldErrors(const SolidCase& one, double least, double most, double outermost,
                        int clouds, const BodyMaker& settings);

// The worst claims a field makes about which side a point is on, at points up to 4 voxels from the
// solid's bounds: the largest depth at points outside it, and the least at points `deepest` inside.
struct FieldSides {
  double falseOverlap = -1e9, falseGap = 1e9;
  int outside = 0, inside = 0;            // points asked, and known to the field
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
  double normalMean = 0;             // [deg] farther than a voxel from edges
  // A box's faces beside its edges: the integral of max(0, d - distance to the edge) along each
  // side of each edge over its true value, less 1, at d = 0.5 and 1: the push of a wall pressed in
  // by d.
  double stripMean[2] = {}, stripWorst[2] = {};
};
SampleSums sampleSums(const SolidCase& one, const Body& body);

}  // namespace cloudcontact::testing
