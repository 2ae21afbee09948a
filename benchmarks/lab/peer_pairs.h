// What the adapters of Bullet, FCL, ODE and MuJoCo share. The latter three are built where all of
// them are installed (CLOUDCONTACT_PEERS in CMakeLists.txt); else otherMethods() lists them as not
// built.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "lab/pair.h"

namespace cloudcontact::program::lab {

std::vector<LabMethod> fclMethods();
std::vector<LabMethod> odeMethods();
std::vector<LabMethod> mujocoMethods();

// Facet tolerance / size of the case. A sphere has 642 vertices and 1280 triangles at 1/100, 2562
// and 5120 at 1/500, 10,242 and 20,480 at 1/2000. The tori have 2,112, 9,984 and 37,600 triangles;
// such parts come from scanners and CAD with about the last number.
constexpr double kCoarseFacets = 1.0 / 100;
constexpr double kFineFacets = 1.0 / 500;
constexpr double kFinestFacets = 1.0 / 2000;
constexpr double kFacetLadder[] = {kCoarseFacets, kFineFacets, kFinestFacets};

// "1/100"
std::string fraction(double detail);
// "facets within 1/100 of the size"
std::string facetsWithin(double detail);

// A library's name and version.
using Version = std::pair<std::string, std::string>;
std::vector<Version> peerVersions();  // of all but Bullet
Version fclVersion();
Version odeVersion();
Version mujocoVersion();

bool isHalfSpace(const LabBody& body);
// Throws CannotDo where the body is no primitive.
const Solid& primitiveOf(const LabBody& body);

// Maximum distance of the body from its origin [m], by a primitive's bounds or the mesh's vertices.
double reachOf(const LabBody& body, double tolerance);

// The points with positive depth, each with an equal share of the pair's spring: none of these
// libraries weights its points.
std::vector<LabPoint> touching(std::vector<LabPoint> points);

// A pair from two functions: one returns the points at a pose, the other is the call to be timed.
LabPair pairOf(const std::function<std::vector<LabPoint>(const Pose& b)>& find,
               const std::function<void(const Pose& b)>& narrowPhase);

// Times of `repeat` calls at jittered poses (LabPair::microseconds) [us]. One untimed call precedes
// them.
std::vector<double> timedCalls(const Pose& b, int repeat, double jitter,
                               const std::function<void(const Pose&)>& call);

// The method on bodies scaled so that the smaller one reaches 1 m from its origin; its answer is
// scaled back. Peers have absolute tolerances made for bodies of about that size, and their manuals
// advise such units. Example: Bullet's EPA in float is 15 to 70 degrees off on the hulls of two
// spheres of 2 cm, and right on spheres of 1 m.
LabMethod atMeterScale(const LabMethod& method);
// The same as a text for the report.
std::string whyMeterScale();

}  // namespace cloudcontact::program::lab
