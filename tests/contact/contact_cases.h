// Pairs of bodies whose contact is known in closed form, and how far a found contact is from it.
// Shared by the contact tests and by the program contact_table. Nothing here asks the library what
// is true: the truths are those of the ideal solids, the meshes are those solids to 0.003 voxel.
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

// Solids about the origin. Facets stray from the true curved surface by less than `tolerance` [m],
// and keep its volume (sphere) or cross-section (cylinder, axis z).
Mesh boxMesh(const Vec3& edges);
Mesh sphereMesh(double radius, double tolerance);
Mesh cylinderMesh(double radius, double height, double tolerance);
Mesh transformed(const Mesh& mesh, const Pose& pose);
Hull boxAsHull(const Vec3& half);

// One side of a case. A cloud's grid does not lie along the solid's axes: `grid` places the solid
// in the frame that was digitised.
struct Body {
  std::shared_ptr<const SurfaceField> field;
  std::optional<Solid> shape;
  Pose grid;

  // The body with its *solid* at `pose`.
  ContactBody at(const Pose& pose) const;
};

// Digitises solids, each at its own grid direction and phase.
struct BodyMaker {
  double voxel;  // [m]
  Random random;
  FieldSettings field{};

  // The mesh as a cloud, its grid turned at random, or along its axes; the phase always random.
  Body cloud(const Mesh& mesh, bool aligned = false);
  Body box(const Vec3& voxels, bool aligned = false);
  Body sphere(double radiusVoxels);
  Body cylinder(double radiusVoxels, double heightVoxels);
  static Body shape(const Solid& analytic);
};

// What is true of two solids pressed together, in the frame of the case.
struct Truth {
  Vec3 normal = Vec3::UnitZ();  // from A to B
  double depth = 0;             // [m] the shift along the normal that just parts them
  Vec3 centre = Vec3::Zero();   // [m] centre of the overlap: the force's axis goes through it
  double volume = 0;            // [m^3] of the overlap; 0 where it is not worked out

  // The size of the force [N]. Paper's law: one spring a pair, k d. Foundation: a pressure k d on
  // the surface of a body in a half-space is Archimedes' law, k times the volume under it.
  double force(const ContactSettings& settings) const;
};

struct Placed {
  Pose a, b;  // of the solids
  Truth truth;
};

// Two bodies, and where they stand when pressed by a depth [m].
struct Instance {
  Body a, b;
  std::function<Placed(double depth)> place;
};

// What a case must keep; infinite where nothing is asked of it. Voxels and degrees.
struct Bounds {
  double normalDeg, depth, centre, forceRelative;
};

struct ContactCase {
  std::string name;
  std::vector<double> depths;  // [voxels] at which the bounds hold
  Bounds bounds;
  std::function<Instance(BodyMaker&)> make;
};

// All cases; names are unique, words parted by dashes.
std::vector<ContactCase> contactCases();
// The case of that name; throws where there is none.
ContactCase contactCase(const std::string& name);
// A case's name as gtest allows it, and as it shows it.
std::string testName(std::string caseName);
void PrintTo(const ContactCase& one, std::ostream* out);

// How far a contact is from the truth. Lengths in voxels.
struct ContactErrors {
  double normalDeg = 180;     // total force against the true normal
  double depth = 0;           // heaviest patch's depth less the true one
  double centre = 1e3;        // true centre to the axis of the wrench
  double forceRelative = -1;  // |force| over the true one, less 1
  double spin = 0;            // moment along the force, over the force
  std::size_t patches = 0, points = 0, samples = 0;
};
ContactErrors compare(const ContactResult& found, const Truth& truth, const Pose& world,
                      const ContactSettings& settings, double voxel);

// The contact of an instance, all of it placed by `world` first, or B's side asked first. The truth
// is in the case's frame, as `place` gave it.
const ContactResult& findContact(ContactFinder& finder, const Instance& instance,
                                 const Placed& placed, const Pose& world,
                                 const ContactSettings& settings, bool swapped = false);

// Mean and largest size of the errors over instances of one case at one depth.
struct ErrorSummary {
  ContactErrors mean, worst;
  double depthBias = 0, forceBias = 0;  // means with their sign
  int missed = 0, runs = 0;             // missed: no contact found
};
struct RunSettings {
  double voxel = 1e-3;  // [m]
  int instances = 12;
  std::uint64_t seed = 1;
  ContactSettings contact{};
  FieldSettings field{};
};
// One summary a depth [voxels]; every instance has its own grids, poses and place in the world.
std::vector<ErrorSummary> runCase(const ContactCase& one, const std::vector<double>& depths,
                                  const RunSettings& settings);

}  // namespace cloudcontact::testing
