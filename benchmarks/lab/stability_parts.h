// What the stability scenes are made of: simple meshes, bodies, one run of a world, and the rules
// that are put to what came out of it.
#pragma once

#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "lab/solids.h"
#include "lab/stability.h"
#include "lab/trial_bodies.h"
#include "scene/penetration.h"

namespace cloudcontact::program::lab {

// What "in place" means: half a voxel, below which no cloud knows where its surface is.
constexpr double kInPlace = 0.5;  // [voxels]

// A frustum over 0 <= z <= height between two rectangles about the z axis; a side of 0 makes a
// wedge's edge or a spike's tip.
Mesh taperedMesh(const Eigen::Vector2d& bottom, const Eigen::Vector2d& top, double height);
// An outline of (x, z), counter-clockwise seen from -y, swept over |y| <= width / 2.
Mesh prismMesh(const Outline& outline, double width);

// Static where mass is 0. Bodies of one `kind` have one mesh.
SceneBody meshBody(const std::string& kind, std::shared_ptr<const Mesh> mesh, const Pose& pose,
                   double mass, double friction);
// Boxes and spheres are primitives for clouds and for Bullet's own shapes, meshes for the others.
SceneBody boxBody(const Trial& trial, const Vec3& size, const Pose& pose, double mass,
                  double friction);
SceneBody sphereBody(const Trial& trial, double radius, const Pose& pose, double mass,
                     double friction);
SceneBody floorBody(double friction);  // z <= 0

// The pair's k and c. Every body states twice as much, since two press in series.
struct Spring {
  double stiffness = 0;  // [N/m]
  double damping = 0;    // [N s/m]
};
// Damping ratio 1 for a body of `mass` that the spring lets sag by `sag` under `load` [kg].
Spring springFor(double mass, double load, double sag);

struct Plan {
  SceneDescription scene;  // names and models are given to the bodies by judged()
  double voxel = 0;        // [m]
  double seconds = 1;
  Spring spring;       // of every pair, where the trial's mode is "stiff"
  int instants = 200;  // of penetration
  // Piles: only bodies that are near each other are measured, boxes against boxes.
  bool many = false;
  std::function<void(double time, const World&)> observe;
};

// What a run's rules look at.
struct Course {
  SceneDescription scene;
  SimulationReport report;
  double voxel = 0;

  double moved(int body) const { return moved(body, scene.bodies[body].pose.position); }
  double moved(int body, const Vec3& from) const;  // [voxels]
  double aside(int body) const;                    // level [voxels]
  double turned(int body) const;                   // since the start, about any axis [deg]
  double deepest() const { return report.maxPenetration / voxel; }  // [voxels]
  // The energy that the bodies had above the start's, as the height of a lift of all that moves.
  double lifted() const;  // [voxels]
};

struct Rule {
  double figure = 0, limit = 0;
  std::string what;  // "tilt [deg]"
};
// Half a voxel at most [voxels].
Rule penetrationRule(const Course& course);
// A tenth of a voxel at most: sags and bumps of a surface give so much, no more.
Rule energyRule(const Course& course);
// A turn that moves the end of a lever by half a voxel.
double turnLimit(double voxel, double lever);  // [deg]

// Runs and judges. The verdict's figure is the first rule's; all must hold. A world whose state is
// no longer finite fails.
using Rules = std::function<std::vector<Rule>(const Course&)>;
Verdict judged(const Trial& trial, Plan plan, const Rules& rules);

}  // namespace cloudcontact::program::lab
