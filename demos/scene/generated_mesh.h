// Closed meshes from formulas, for demos and tests without files: threads, chain links, pegs and
// holes. In meters, watertight, triangles counter-clockwise from outside.
#pragma once

#include <cloudcontact/mesh/mesh.h>

namespace cloudcontact::program {

// An ISO metric screw thread (basic profile: flat of pitch/8 at the major diameter, pitch/4 at the
// minor), axis z, its crest crossing the x axis at z = 0.
struct Thread {
  double majorDiameter = 16e-3;  // [m]
  double pitch = 2e-3;           // [m], from one crest to the next
  int starts = 1;                // number of parallel threads
  bool leftHanded = false;
  double flankAngle = 1.0471975511965976;  // [rad] between the two flanks, 60 deg
  double clearance = 0;                    // [m] radial: shrinks the bolt, widens the nut
  int segments = 192;     // around the axis, a multiple of 24 (hexagon corners, starts)
  int profileSteps = 16;  // along a pitch, a multiple of 16 (the profile's corners)

  double lead() const { return starts * pitch; }  // [m] per turn
};

// The thread's radius [m] at an axial distance from the middle of a crest, without clearance.
double threadRadius(const Thread& thread, double axial);

// A threaded rod over 0 <= z <= length, its ends chamfered to below the minor diameter. A positive
// `headWidth` (across flats) adds a hexagonal head of `headHeight` under z = 0.
Mesh boltMesh(const Thread& thread, double length, double headWidth = 0, double headHeight = 0);

// A hexagonal nut over 0 <= z <= height, `width` across flats, chamfered inside.
Mesh nutMesh(const Thread& thread, double height, double width);

// A torus swept along a stadium in the x-y plane, long axis y: two half circles of `bend` (radius
// of the wire's middle) and two straights of `straight`. Volume pi wire^2 (2 pi bend + 2 straight).
struct ChainLink {
  double wire = 0.1;      // radius of the wire [m]
  double bend = 0.25;     // [m]
  double straight = 0.5;  // [m]
  int around = 48;        // facets around the wire
  int along = 64;         // facets along each half circle
};
Mesh chainLinkMesh(const ChainLink& link);

// A round peg over 0 <= z <= length, both ends chamfered.
Mesh pegMesh(double radius, double length, double chamfer, int segments = 192);

// A square block over 0 <= z <= height with a round through hole along z, chamfered at the top.
// `segments` is a multiple of 8.
Mesh holeMesh(double radius, double width, double height, double chamfer, int segments = 192);

}  // namespace cloudcontact::program
