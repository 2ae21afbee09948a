// Reference cases: pairs of solids pressed together whose contact is known in closed form. Nothing
// here asks the library, or any method, what is true.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lab/pair.h"

namespace cloudcontact::program::lab {

// What is true of a pair at one pose, of the force on B. What is not known in closed form, or not
// the same under every law, is left out: where a body touches in several places at once, how much
// of the one spring each has is the law's to say.
struct Truth {
  Vec3 direction = Vec3::UnitZ();  // of the force on B
  std::optional<double> depth;     // [m] how far B must move along it until they part
  std::optional<Vec3> centre;      // a point of the force's axis [m]
  // Of a screw about z, by the force along z [m]; centre is then on its axis.
  std::optional<double> torquePerForce;
  // [m] how deep the deepest point of either surface lies, where that is not `depth`.
  std::optional<double> deepest = {};
  // Where two places are pressed unequally, which way the force leans is the law's to say: one that
  // grows with depth as a spring's points along `direction`, one that grows with its square along
  // this. Anything between is right.
  std::optional<Vec3> squareLaw = {};
};

struct Placement {
  Pose b;
  Truth truth;
};

// One pair with its grids, in all its poses.
struct Instance {
  LabBody a, b;
  std::vector<Placement> placements;
};

struct LabCase {
  std::string family, name;
  bool convex = false;
  bool smooth = false;  // curved surfaces without edges in contact
  double size = 0;      // [m] the radius or half width that details are shares of
  bool quick = true;
  std::function<Instance(std::uint64_t seed)> make;
};

// SplitMix64 (Steele, Lea, Flood 2014): the same numbers everywhere.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform(double low, double high);
  Eigen::Quaterniond rotation();  // uniform over all rotations
  Pose grid(double voxel);        // turned at random, shifted by less than a voxel

 private:
  std::uint64_t state_;
};

// How deep bodies are pressed, in shares of the size: 0.4, 0.7 and 1 voxel at size / 32.
constexpr double kDepths[] = {0.0125, 0.022, 0.031};

std::vector<LabCase> convexCases();   // spheres, cylinders, boxes
std::vector<LabCase> concaveCases();  // rings, holes, threads, pegs, plates
std::vector<LabCase> grooveCases();   // capsules and spikes in V grooves
std::vector<LabCase> deepCases();     // concave bodies deep in each other
std::vector<LabCase> randomCases();   // meshes thrown together anyhow; truth by oracle.h
std::vector<LabCase> allCases();

}  // namespace cloudcontact::program::lab
