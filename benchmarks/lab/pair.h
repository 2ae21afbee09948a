// The interface of all methods: a pair of bodies is prepared once, then queried for its contact at
// any pose, and timed.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/contact/work_counts.h>
#include <cloudcontact/law/solid.h>
#include <cloudcontact/mesh/mesh.h>

#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace cloudcontact::program::lab {

// A body of a case. Every method gets the same solid; methods that take triangles get facets at the
// tolerance of their setting.
struct LabBody {
  std::string name;
  // Facets within `tolerance` [m] of the solid, or a file's own triangles; empty for a half-space.
  std::function<Mesh(double tolerance)> mesh;
  std::optional<Solid> shape;  // of a primitive
  bool convex = false;
  Pose grid;  // pose of a cloud's voxel grid in the body's frame
};

// A contact point as the method reports it; only points with depth > 0.
struct LabPoint {
  Vec3 position = Vec3::Zero();  // midway between the surfaces [m]
  Vec3 normal = Vec3::UnitZ();   // from A to B
  double depth = 0;              // [m]
  double share = 0;              // of the pair's spring; all points together have at most 1
};

// A prepared pair. A is at the origin, B at the pose of the query.
struct LabPair {
  std::function<std::vector<LabPoint>(const Pose& b)> find;
  // Time of each of `repeat` calls [us]. Before each, B moves by `jitter` [m] in a new direction,
  // so that no cache answers.
  std::function<std::vector<double>(const Pose& b, int repeat, double jitter)> microseconds;
  // Of both bodies as the method represents them [m^3]; empty where it does not know.
  std::optional<double> volume = {};
  // The pair (b, a) of the same bodies, where that is cheaper than preparing it again.
  std::function<LabPair()> swapped = {};
  // What one query takes, the first of its pair; only of CloudContact.
  std::function<WorkCounts(const Pose& b)> work = {};
};

// Why a method has no answer for a pair; the chart shows the reason.
struct CannotDo : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// One mark in the chart: a method at one setting.
struct LabMethod {
  std::string method;   // as --method names it: cloud, paper, gjk, ..., fcl, ode, mujoco
  std::string setting;  // "voxel 1/32", "window 2.5", "642 vertices"
  // Voxel or facet tolerance / size of the case, e.g. 1/32; 0 where the method has neither.
  double detail = 0;
  // `detail` in meters. Throws CannotDo.
  std::function<LabPair(const LabBody& a, const LabBody& b, double detail)> prepare;
  std::string description = {};  // margins, thresholds and options, for the report
  bool facets = false;           // takes meshes with facets within `detail`
  bool meterScale = false;       // gets bodies scaled to about 1 m (peer_pairs.h explains why)
};

// Whether a method is one of CloudContact's own, with voxels: "cloud" or "paper".
bool isOwn(const std::string& method);

std::vector<LabMethod> cloudMethods();   // one per voxel size
std::vector<LabMethod> paperMethods();   // one per window of base vectors
std::vector<LabMethod> bulletMethods();  // primitive, GJK/EPA, GImpact, HACD, btSdfCollisionShape
std::vector<LabMethod> otherMethods();   // FCL, ODE, MuJoCo

}  // namespace cloudcontact::program::lab
