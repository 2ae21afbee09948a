// Pairs of bodies whose contact is known in closed form, and the errors of a contact found. Shared
// by the contact tests and the program contact_table. The truth never comes from the library but
// from the ideal solids; the meshes match these to 0.003 voxel.
#pragma once

#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/mesh/mesh.h>

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace cloudcontact::testing {

// SplitMix64 (Steele, Lea, Flood 2014): the same sequence with every compiler and library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform();  // [0, 1)
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  Vec3 inCube();                  // each component in [0, 1)
  Eigen::Quaterniond rotation();  // uniform over all rotations
  Eigen::Quaterniond yaw();       // about z
 private:
  std::uint64_t state_;
};

// Solids centered at the origin. Facets deviate from the curved surface by less than `tolerance`
// [m] and keep its volume (sphere) or cross-section (cylinder, axis z).
Mesh boxMesh(const Vec3& edges);
Mesh sphereMesh(double radius, double tolerance);
Mesh cylinderMesh(double radius, double height, double tolerance);
Mesh transformed(const Mesh& mesh, const Pose& pose);
Hull boxAsHull(const Vec3& half);

// One body of a case. A cloud's grid is not aligned with the solid's axes: `grid` places the solid
// in the frame that was digitized.
struct Body {
  std::shared_ptr<const SurfaceField> field;
  std::optional<Solid> shape;
  Pose grid;

  // The body with its *solid* at `pose`.
  ContactBody at(const Pose& pose) const;
};

// Digitizes solids, each with its own grid direction and phase.
struct BodyMaker {
  double voxel;  // [m]
  Random random;
  FieldSettings field{};

  // The mesh as a cloud. Its grid is turned at random unless `aligned`, and has a random phase.
  Body cloud(const Mesh& mesh, bool aligned = false);
  Body box(const Vec3& voxels, bool aligned = false);
  Body sphere(double radiusVoxels);
  Body cylinder(double radiusVoxels, double heightVoxels);
  static Body shape(const Solid& analytic);
};

// The true contact of two solids pressed together, in the frame of the case.
struct Truth {
  Vec3 normal = Vec3::UnitZ();  // from A to B
  double depth = 0;             // [m] shift along the normal that just separates them
  Vec3 center = Vec3::Zero();   // [m] of the overlap; on the axis of the force
  double volume = 0;            // [m^3] of the overlap; 0: not known

  // Magnitude of the force [N]. Paper's law: one spring per pair, k d. Foundation: a pressure k d
  // on the surface of a body in a half-space is Archimedes' law, k times the volume under the
  // plane.
  double force(const ContactSettings& settings) const;
};

struct Placed {
  Pose a, b;  // of the solids
  Truth truth;
};

// Two bodies, and their poses when pressed by a depth [m].
struct Instance {
  Body a, b;
  std::function<Placed(double depth)> place;
};

// Bounds on a case's errors, in voxels and degrees; infinite: no bound.
struct Bounds {
  double normalDeg, depth, center, forceRelative;
};

struct ContactCase {
  std::string name;
  std::vector<double> depths;  // [voxels] at which the bounds hold
  Bounds bounds;
  std::function<Instance(BodyMaker&)> make;
};

// All cases. Names are unique, with dashes between words.
std::vector<ContactCase> contactCases();
// The case of that name. Throws std::invalid_argument if there is none.
ContactCase contactCase(const std::string& name);
// A case's name as gtest allows it, and in gtest's messages.
std::string testName(std::string caseName);
void PrintTo(const ContactCase& one, std::ostream* out);

// Errors of a contact. Lengths in voxels.
struct ContactErrors {
  double normalDeg = 180;     // total force against the true normal
  double depth = 0;           // depth of the heaviest patch, minus the true one
  double center = 1e3;        // distance from the true center to the wrench's axis
  double forceRelative = -1;  // |force| relative to the true one, minus 1
  double spin = 0;            // moment along the force, per force
  std::size_t patches = 0, points = 0, samples = 0;
};
ContactErrors compare(const ContactResult& found, const Truth& truth, const Pose& world,
                      const ContactSettings& settings, double voxel);

// The contact of an instance moved by `world`, optionally with the bodies swapped. The truth stays
// in the case's frame.
ContactResult findContact(ContactFinder& finder, const Instance& instance, const Placed& placed,
                          const Pose& world, const ContactSettings& settings, bool swapped = false);

// Mean and largest errors over instances of one case at one depth.
struct ErrorSummary {
  ContactErrors mean, worst;
  double depthBias = 0, forceBias = 0;  // signed means
  int missed = 0, runs = 0;             // missed: no contact found
};
struct RunSettings {
  double voxel = 1e-3;  // [m]
  int instances = 12;
  std::uint64_t seed = 1;
  ContactSettings contact{};
  FieldSettings field{};
};
// One summary per depth [voxels]. Every instance has its own grids and poses.
std::vector<ErrorSummary> runCase(const ContactCase& one, const std::vector<double>& depths,
                                  const RunSettings& settings);

}  // namespace cloudcontact::testing
