// A pair of bodies as one method sees it: made ready once, then asked for its contact at any pose,
// and timed.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/law/solid.h>
#include <cloudcontact/mesh/mesh.h>

#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace cloudcontact::program::lab {

// A body of a case, about its own origin. Every method gets the same solid; those that take
// triangles get it faceted to a tolerance of their setting.
struct LabBody {
  std::string name;
  // Facets no further than `tolerance` [m] from the solid, or the file's own triangles; empty for a
  // half-space.
  std::function<Mesh(double tolerance)> mesh;
  std::optional<Solid> shape;  // where it is a primitive
  bool convex = false;
  Pose grid;  // of a cloud's grid in the body's frame: voxels do not lie along a body's axes
};

// A point of contact as the method reports it; only those that touch (depth > 0).
struct LabPoint {
  Vec3 position = Vec3::Zero();  // midway between the surfaces [m]
  Vec3 normal = Vec3::UnitZ();   // from A to B
  double depth = 0;              // [m]
  double share = 0;  // of the pair's one spring (1); a method's points add up to 1 at most
};

// A pair made ready. A stands at the origin, B at the pose asked for.
struct LabPair {
  std::function<std::vector<LabPoint>(const Pose& b)> find;
  // Of each of `repeat` calls, B moved by `jitter` [m] in another direction before each, so that
  // nothing is answered from memory [us].
  std::function<std::vector<double>(const Pose& b, int repeat, double jitter)> microseconds;
  // Of both bodies as the method has them [m^3]; empty where it has none.
  std::optional<double> volume = {};
  // The pair (b, a) of the same two bodies, where that is cheaper than to make it ready anew.
  std::function<LabPair()> swapped = {};
};

// Why a method has no answer for a pair: told in the chart.
struct CannotDo : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// One mark in the chart: a method and how it is set.
struct LabMethod {
  std::string method;   // as --method names it: cloud, primitive, gjk, ..., fcl, ode, mujoco
  std::string setting;  // "voxel 1/32", "642 vertices"
  // What its accuracy hangs on, the voxel or the facets' tolerance, by the case's size: 1/32.
  double detail = 0;
  // `detail` in metres. Throws CannotDo.
  std::function<LabPair(const LabBody& a, const LabBody& b, double detail)> prepare;
  std::string told = {};    // how it is set, for a stranger: margins, thresholds, solver options
  bool facets = false;      // takes meshes of facets within `detail`
  bool metreScale = false;  // sees bodies of about a metre (pair_others.h says why)
};

// The times of `repeat` runs of `call`, each at a pose jittered as above; one more runs first,
// untimed.
std::vector<double> timedCalls(const Pose& b, int repeat, double jitter,
                               const std::function<void(const Pose&)>& call);

std::vector<LabMethod> cloudMethods();   // one a voxel size
std::vector<LabMethod> bulletMethods();  // primitive, GJK/EPA, GImpact, HACD, btSdfCollisionShape
std::vector<LabMethod> otherMethods();   // FCL, ODE, MuJoCo

}  // namespace cloudcontact::program::lab
