// Reference cases: pairs of solids pressed together whose contact is known in closed form, or by
// quadrature that shares no code with the library.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lab/pair.h"

namespace cloudcontact::program::lab {

// The true contact of a pair at one pose; forces act on B. What has no closed form, or depends on
// the contact law, is left out. Example: how a pair that touches in several places divides its
// spring among them.
struct Truth {
  Vec3 direction = Vec3::UnitZ();  // of the force on B
  std::optional<double> depth;     // [m] distance along `direction` until the bodies separate
  std::optional<Vec3> center;      // a point on the force's axis [m]
  // For a screw about z: torque / force along z [m]; `center` is then on the screw's axis.
  std::optional<double> torquePerForce;
  // [m] depth of the deepest point of either surface, where it differs from `depth`.
  std::optional<double> deepest = {};
  // Where two places are pressed unequally, the force's direction depends on the law: a force
  // linear in depth points along `direction`, a quadratic one along `squareLaw`. Any direction
  // between the two counts as right.
  std::optional<Vec3> squareLaw = {};
};

struct Placement {
  Pose b;
  Truth truth;
};

// One pair with its voxel grids, in all its poses.
struct Instance {
  LabBody a, b;
  std::vector<Placement> placements;
};

struct LabCase {
  std::string family, name;
  bool convex = false;
  bool smooth = false;  // curved surfaces, no edges in contact
  double size = 0;      // [m] radius or half width; details are shares of it
  bool quick = true;    // part of the quick run
  std::function<Instance(std::uint64_t seed)> make;
};

// Depths of the cases, as shares of the size: 0.4, 0.7 and 1 voxel of size / 32.
constexpr double kDepths[] = {0.0125, 0.022, 0.031};

std::vector<LabCase> convexCases();   // spheres, cylinders, boxes
std::vector<LabCase> concaveCases();  // rings, holes, threads, pegs, plates
std::vector<LabCase> grooveCases();   // capsules and wedges in V grooves
std::vector<LabCase> deepCases();     // concave bodies deep in each other
std::vector<LabCase> randomCases();   // meshes in random poses; truth by oracle.h
std::vector<LabCase> allCases();

}  // namespace cloudcontact::program::lab
