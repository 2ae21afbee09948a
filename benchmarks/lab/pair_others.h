// What the peers share, Bullet's own methods and those outside it: FCL, ODE and MuJoCo, a file
// each. These are built where all three are installed (CLOUDCONTACT_PEERS in demos/CMakeLists.txt);
// else otherMethods() names them, and they cannot.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "lab/pair.h"

namespace cloudcontact::program::lab {

std::vector<LabMethod> fclMethods();
std::vector<LabMethod> odeMethods();
std::vector<LabMethod> mujocoMethods();

// How far facets may lie from the solid, by the case's size. On a sphere of that radius 1/100 gives
// 642 vertices and 1280 triangles, 1/500 2562 and 5120, 1/2000 10,242 and 20,480; on the tori of
// the rings 2,112, 9,984 and 37,600 triangles, the last about as many as such parts come with from
// scanners and CAD.
constexpr double kCoarseFacets = 1.0 / 100;
constexpr double kFineFacets = 1.0 / 500;
constexpr double kFinestFacets = 1.0 / 2000;
constexpr double kFacetLadder[] = {kCoarseFacets, kFineFacets, kFinestFacets};

// "1/100"
std::string fraction(double detail);
// "facets within 1/100 of the size"
std::string facetsWithin(double detail);

// A library, and which version of it was measured.
using Version = std::pair<std::string, std::string>;
std::vector<Version> peerVersions();  // of all but Bullet
Version fclVersion();
Version odeVersion();
Version mujocoVersion();

bool isHalfSpace(const LabBody& body);
// Throws CannotDo where the body is no primitive.
const Solid& primitiveOf(const LabBody& body);

// How far the body reaches from its origin [m]: a primitive's box, or the facets' vertices.
double reachOf(const LabBody& body, double tolerance);

// The points that touch, with the pair's one spring shared equally among them: none of these
// libraries says how much of it a point carries.
std::vector<LabPoint> touching(std::vector<LabPoint> points);

// A pair of which a method only has to say what it answers at a pose; the time is that of the same
// call.
LabPair pairOf(const std::function<std::vector<LabPoint>(const Pose& b)>& find,
               const std::function<void(const Pose& b)>& narrowPhase);

// The method over bodies scaled so that the smaller one reaches 1 m from its origin, and its answer
// scaled back. Every peer has tolerances in metres, made for bodies of about that size, and their
// users are told to choose units so: Bullet's EPA in float (1e-4) puts the normal of two 2 cm
// spheres' hulls, 0.6 mm deep, 15 to 70 degrees off, and answers them well as 1 m spheres.
LabMethod atMetreScale(const LabMethod& method);
// The same for whoever reads the chart.
std::string whyMetreScale();

}  // namespace cloudcontact::program::lab
