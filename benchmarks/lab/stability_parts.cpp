// Meshes, bodies, runs and rules of the stability scenes.
#include "lab/stability_parts.h"

#include <cloudcontact/mesh/mesh_repair.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "demos/demo.h"
#include "io/errors.h"
#include "scene/primitive_mesh.h"

namespace cloudcontact::program::lab {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kMostLift = 0.1;  // [voxels]

// The deepest of many bodies of one collision each: those whose bounding balls are apart are not
// looked at. World::penetration() looks at all pairs, which a pile cannot afford.
class NearbyOverlap {
 public:
  explicit NearbyOverlap(const SceneDescription& scene) {
    std::map<std::string, std::shared_ptr<const Probed>> known;
    for (const SceneBody& body : scene.bodies) {
      auto& kept = known[body.collisions[0].name];
      if (!kept) kept = measured(body.collisions[0].geometry);
      double radius = kept->probes.empty() ? std::numeric_limits<double>::infinity() : 0;
      for (const Probe& probe : kept->probes)
        radius = std::max(radius, probe.position.norm() + probe.radius);
      bodies_.push_back({{{{kept, Pose()}}}, radius, body.isStatic});
    }
  }

  double deepest(const World& world) const {
    double deepest = 0;
    for (std::size_t a = 0; a < bodies_.size(); ++a)
      for (std::size_t b = a + 1; b < bodies_.size(); ++b) {
        const Body &one = bodies_[a], &other = bodies_[b];
        const Pose &at = world.pose(a), &there = world.pose(b);
        if (one.fixed && other.fixed) continue;
        if ((at.position - there.position).norm() > one.radius + other.radius) continue;
        deepest = std::max(deepest, penetration(one.solids, at, other.solids, there));
      }
    return deepest;
  }

 private:
  struct Body {
    MeasuredBody solids;
    double radius = 0;
    bool fixed = false;
  };
  static std::shared_ptr<const Probed> measured(const SceneGeometry& geometry) {
    if (const auto* box = std::get_if<SceneBox>(&geometry)) {
      const Mesh mesh = primitiveMesh(Box{box->size / 2}, box->size.norm());
      return probed(geometry, &mesh);
    }
    const auto* mesh = std::get_if<SceneMesh>(&geometry);
    return probed(geometry, mesh ? mesh->mesh.get() : nullptr);
  }

  std::vector<Body> bodies_;
};

void prepare(SceneDescription& scene, const Trial& trial, const Spring& spring) {
  scene.step = trial.step;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    SceneBody& body = scene.bodies[i];
    body.model = static_cast<int>(i);
    body.name = body.collisions[0].name + std::to_string(i);
    if (trial.mode != "stiff") continue;
    body.stiffness = 2 * spring.stiffness;
    body.damping = 2 * spring.damping;
  }
}

// simulate() for a pile: the same figures, penetration by NearbyOverlap.
SimulationReport simulateMany(World& world, const Plan& plan, double step) {
  const NearbyOverlap overlap(plan.scene);
  SimulationReport report;
  report.step = step;
  report.steps = static_cast<int>(std::llround(plan.seconds / step));
  double due = 0;
  for (int n = 1; n <= report.steps; ++n) {
    world.step(step);
    const Energy& energy = world.moment().energy;
    if (n == 1) report.energyStart = energy, report.energyMax = energy.ofBodies();
    report.energyMax = std::max(report.energyMax, energy.ofBodies());
    if (plan.observe) plan.observe(n * step, world);
    if (n * step < due && n < report.steps) continue;
    due += plan.seconds / plan.instants;
    report.maxPenetration = std::max(report.maxPenetration, overlap.deepest(world));
  }
  for (std::size_t i = 0; i < world.bodyCount(); ++i) report.bodies.push_back(world.state(i));
  return report;
}

Course follow(const Trial& trial, Plan& plan) {
  prepare(plan.scene, trial, plan.spring);
  if (trial.watch)
    plan.observe = [own = plan.observe, watch = trial.watch](double time, const World& world) {
      if (own) own(time, world);
      watch(time, world);
    };
  World world(plan.scene, worldSettings(trial, plan.voxel));
  if (plan.many) return {plan.scene, simulateMany(world, plan, trial.step), plan.voxel};
  SimulationSettings simulation;
  simulation.seconds = plan.seconds;
  simulation.step = trial.step;
  simulation.instants = plan.instants;
  simulation.mostProbes = std::numeric_limits<std::size_t>::max();
  simulation.observe = plan.observe;
  return {plan.scene, simulate(world, simulation), plan.voxel};
}

}  // namespace

Mesh taperedMesh(const Eigen::Vector2d& bottom, const Eigen::Vector2d& top, double height) {
  Mesh mesh;
  for (const double z : {0.0, height}) {
    const Eigen::Vector2d half = (z > 0 ? top : bottom) / 2;
    for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
      mesh.vertices.emplace_back(x * half.x(), y * half.y(), z);
  }
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}};
  for (int k = 0; k < 4; ++k) {
    const int n = (k + 1) % 4;
    mesh.triangles.emplace_back(k, n, n + 4);
    mesh.triangles.emplace_back(k, n + 4, k + 4);
  }
  return mended(mesh);  // a tip's four corners are one, its empty triangles go
}

Mesh prismMesh(const Outline& outline, double width) {
  Mesh mesh = prism(outline, -width / 2, width / 2);
  for (Vec3& v : mesh.vertices) v = Vec3(v.x(), -v.z(), v.y());
  return mesh;
}

SceneBody meshBody(const std::string& kind, std::shared_ptr<const Mesh> mesh, const Pose& pose,
                   double mass, double friction) {
  SceneBody body;
  body.pose = pose;
  body.isStatic = mass == 0;
  if (mass > 0) body.mass = mass;
  body.friction = friction;
  body.collisions.push_back({kind, Pose(), SceneMesh{kind, Vec3::Ones(), std::move(mesh)}});
  return body;
}

SceneBody boxBody(const Trial& trial, const Vec3& size, const Pose& pose, double mass,
                  double friction) {
  const std::string kind =
      "box " + figure(size.x(), 3) + " " + figure(size.y(), 3) + " " + figure(size.z(), 3);
  SceneBody body = meshBody(kind, {}, pose, mass, friction);
  body.collisions[0].geometry = boxFor(trial, size);
  return body;
}

SceneBody sphereBody(const Trial& trial, double radius, const Pose& pose, double mass,
                     double friction) {
  const std::string kind = "sphere " + figure(radius, 3);
  SceneBody body = meshBody(kind, {}, pose, mass, friction);
  body.collisions[0].geometry = ballFor(trial, radius);
  return body;
}

SceneBody floorBody(double friction) {
  SceneBody body;
  body.isStatic = true;
  body.friction = friction;
  body.collisions.push_back({"floor", Pose(), ScenePlane{}});
  return body;
}

Spring springFor(double mass, double load, double sag) {
  const double stiffness = load * kGravity / sag;
  return {stiffness, 2 * std::sqrt(stiffness * mass)};
}

double Course::moved(int body, const Vec3& from) const {
  return (report.bodies[body].pose.position - from).norm() / voxel;
}

double Course::aside(int body) const {
  const Vec3 off = report.bodies[body].pose.position - scene.bodies[body].pose.position;
  return off.head<2>().norm() / voxel;
}

double Course::turned(int body) const {
  const Eigen::Quaterniond start(scene.bodies[body].pose.orientation);
  return start.angularDistance(report.bodies[body].pose.orientation) * kDegrees;
}

double Course::lifted() const {
  double mass = 0;
  for (const SceneBody& body : scene.bodies) mass += body.mass.value_or(0);
  return (report.energyMax - report.energyStart.ofBodies()) / (mass * kGravity * voxel);
}

Rule penetrationRule(const Course& course) {
  return {course.deepest(), kInPlace, "penetration [voxels]"};
}

Rule energyRule(const Course& course) {
  return {course.lifted(), kMostLift, "energy gained [voxels of lift]"};
}

double turnLimit(double voxel, double lever) {
  return kInPlace * voxel / lever * kDegrees;
}

Verdict judged(const Trial& trial, Plan plan, const Rules& rules) {
  std::vector<Rule> found;
  try {
    found = rules(follow(trial, plan));
  } catch (const WorkFailed& error) {
    return {Outcome::Fails, std::numeric_limits<double>::infinity(), kInPlace, error.what()};
  }
  Verdict verdict{Outcome::Holds, found.front().figure, found.front().limit, ""};
  for (const Rule& rule : found) {
    if (rule.figure <= rule.limit) continue;  // not so for NaN
    verdict.outcome = Outcome::Fails;
    verdict.why += (verdict.why.empty() ? "" : "; ") + rule.what + " " + figure(rule.figure, 3) +
                   " over " + figure(rule.limit, 3);
  }
  return verdict;
}

}  // namespace cloudcontact::program::lab
