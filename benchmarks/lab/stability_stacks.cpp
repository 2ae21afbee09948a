// Scenes whose weight passes through many contacts: stacks, a card house, an arch, a heavy body on
// a light one, chains, a wrecking ball, piles, and long rest.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "lab/lab_meshes.h"
#include "lab/trial_runs.h"
#include "scene/generated_mesh.h"

namespace cloudcontact::program::lab {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kFriction = 0.6;

// Rules for bodies [first, end): maximum horizontal drift and rotation, penetration, energy.
std::vector<Rule> standing(const RunResult& result, int first, double lever) {
  double aside = 0, turned = 0;
  for (int i = first; i < int(result.scene.bodies.size()); ++i) {
    aside = std::max(aside, result.aside(i));
    turned = std::max(turned, result.turned(i));
  }
  return {{aside, kInPlace, "drift [voxels]"},
          {turned, turnLimit(result.voxel, lever), "tilt [deg]"},
          penetrationRule(result),
          energyRule(result)};
}

// Boxes of 2 m and 1 t, as in Bullet's examples. On springs they form a column under its own weight
// with joints of rotational stiffness k edge^2 / 12. It buckles below k = 1.53 m g n^3 / edge
// (Greenhill 1881); the scene uses 2.4 times that.
Verdict stack(const Trial& trial, int boxes, double seconds) {
  constexpr double kEdge = 2, kMass = 1000;
  const double k = 2.4 * 1.53 * kMass * kGravity * boxes * boxes * boxes / kEdge;
  Plan plan;
  plan.voxel = 0.125;
  plan.seconds = seconds;
  plan.instants = 50;
  plan.spring = {k, 2 * std::sqrt(k * kMass / 2)};
  plan.scene.bodies.push_back(floorBody(kFriction));
  for (int i = 0; i < boxes; ++i)
    plan.scene.bodies.push_back(boxBody(trial, Vec3::Constant(kEdge),
                                        {Eigen::Quaterniond::Identity(), {0, 0, (i + 0.5) * kEdge}},
                                        kMass, kFriction));
  return judged(trial, plan, [](const RunResult& c) { return standing(c, 1, kEdge / 2); });
}

// Two cards of 1.5 x 1 x 0.12 m that lean on each other at 20 deg, their top edges touching at x.
void leanTo(std::vector<SceneBody>& bodies, const Trial& trial, double x, double foot,
            double mass) {
  constexpr double kThick = 0.12, kLong = 1.5;
  const double angle = 20 * kPi / 180, c = std::cos(angle), s = std::sin(angle);
  for (const int side : {-1, 1}) {
    const Eigen::Quaterniond leaning(Eigen::AngleAxisd(-side * angle, Vec3::UnitY()));
    const Vec3 at(x + side * (kThick * c + kLong * s) / 2, 0, foot + (kThick * s + kLong * c) / 2);
    bodies.push_back(boxBody(trial, {kThick, 1, kLong}, {leaning, at}, mass, kFriction));
  }
}

// Two pairs of cards, a plate on top, one pair on the plate. The feet need a friction of 0.27:
// cards of weight W under a load P push outward with (W / 2 + P) tan 20 deg each.
Verdict cardHouse(const Trial& trial) {
  constexpr double kMass = 90, kTop = 0.12 * 0.34202 + 1.5 * 0.93969;
  Plan plan;
  plan.voxel = 0.04;
  plan.seconds = 3;
  plan.instants = 50;
  plan.spring = springFor(kMass, 3 * kMass, 0.05 * plan.voxel);
  auto& bodies = plan.scene.bodies;
  bodies.push_back(floorBody(kFriction));
  for (const double x : {-0.7, 0.7}) leanTo(bodies, trial, x, 0, kMass);
  bodies.push_back(boxBody(trial, {2, 1, 0.12},
                           {Eigen::Quaterniond::Identity(), {0, 0, kTop + 0.06}}, kMass * 4 / 3,
                           kFriction));
  leanTo(bodies, trial, 0, kTop + 0.12, kMass);
  return judged(trial, plan, [](const RunResult& c) { return standing(c, 1, 0.75); });
}

// Nine wedge-shaped stones on a half circle between the radii 2 and 3 m, held only by their shape
// and a friction of 0.7. The arch is four times as thick as it must be to stand (0.1075 of its
// radius, Milankovitch 1907).
Verdict arch(const Trial& trial) {
  constexpr int kStones = 9;
  constexpr double kInner = 2, kOuter = 3, kMass = 2000;
  const double half = kPi / kStones / 2, middle = (kInner + kOuter) / 2;
  const auto corner = [&](double radius, double angle) {
    return Eigen::Vector2d(radius * std::sin(angle), radius * std::cos(angle) - middle);
  };
  const auto mesh = std::make_shared<const Mesh>(prismMesh(
      {corner(kInner, -half), corner(kInner, half), corner(kOuter, half), corner(kOuter, -half)},
      1));
  Plan plan;
  plan.voxel = 0.0625;
  plan.seconds = 3;
  plan.instants = 50;
  plan.spring = springFor(kMass, kStones * kMass / 2, 0.05 * plan.voxel);
  plan.scene.bodies.push_back(floorBody(0.7));
  for (int i = 0; i < kStones; ++i) {
    const double angle = -kPi / 2 + (2 * i + 1) * half;
    plan.scene.bodies.push_back(
        meshBody("stone", mesh,
                 {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Vec3::UnitY())),
                  middle * Vec3(std::sin(angle), 0, std::cos(angle))},
                 kMass, 0.7));
  }
  return judged(trial, plan, [](const RunResult& c) { return standing(c, 1, 0.5); });
}

// A cube of 1 t on a cube of 1 kg, both 1 m.
Verdict heavyOnLight(const Trial& trial) {
  Plan plan;
  plan.voxel = 0.1;
  plan.seconds = 3;
  plan.instants = 100;
  plan.spring = springFor(1000, 1001, 0.1 * plan.voxel);
  plan.scene.bodies.push_back(floorBody(kFriction));
  for (const double z : {0.5, 1.5})
    plan.scene.bodies.push_back(boxBody(trial, Vec3::Ones(),
                                        {Eigen::Quaterniond::Identity(), {0, 0, z}},
                                        z < 1 ? 1 : 1000, kFriction));
  return judged(trial, plan, [](const RunResult& result) {
    std::vector<Rule> rules = standing(result, 1, 0.5);
    std::swap(rules[0], rules[2]);  // the verdict's figure is the penetration
    return rules;
  });
}

// Chain links whose wires touch where they cross. The facets are coarse for GImpact and HACD:
// within 2 mm of the round wire, a fifteenth of a voxel.
const ChainLink kLink{0.1, 0.25, 0.6, 12, 10};
constexpr double kPitch = 0.9;  // straight + 2 bend - 2 wire
constexpr double kLinkMass = 40;

std::shared_ptr<const Mesh> linkMesh() {
  return std::make_shared<const Mesh>(chainLinkMesh(kLink));
}

void needsHoles(const Trial& trial) {
  if (trial.method == Method::Gjk)
    throw std::runtime_error("cannot: the convex hull of a link has no hole");
}

// A chain from `top` along the negative y axis of `hung`, which lies in the x-z plane. Every other
// link is turned a quarter about that axis; the first link is fixed.
void hang(std::vector<SceneBody>& bodies, const Eigen::Quaterniond& hung, const Vec3& top,
          int links, const std::vector<double>& sags) {
  const auto mesh = linkMesh();
  const Eigen::Quaterniond quarter(Eigen::AngleAxisd(kPi / 2, Vec3::UnitY()));
  Vec3 at = top;
  for (int i = 0; i < links; ++i) {
    if (i > 0) at -= (kPitch + sags[i]) * (hung * Vec3::UnitY());
    bodies.push_back(
        meshBody("link", mesh, {i % 2 ? hung * quarter : hung, at}, i == 0 ? 0 : kLinkMass, 0.4));
  }
}

// The chain hangs from the start. In the mode "stiff" each joint starts stretched by its load.
Verdict chain(const Trial& trial, int links, double seconds) {
  needsHoles(trial);
  Plan plan;
  plan.voxel = 0.04;
  plan.seconds = seconds;
  plan.instants = 10;
  plan.spring = springFor(kLinkMass / 2, links * kLinkMass, 0.1 * plan.voxel);
  std::vector<double> sags(links, 0.0);
  if (trial.mode == "stiff")
    for (int i = 1; i < links; ++i)
      sags[i] = (links - i) * kLinkMass * kGravity / plan.spring.stiffness;
  const Eigen::Quaterniond up(Eigen::AngleAxisd(kPi / 2, Vec3::UnitX()));
  hang(plan.scene.bodies, up, Vec3(0, 0, links), links, sags);
  return judged(trial, plan, [&](const RunResult& result) {
    double off = 0, aside = 0;
    for (int i = 1; i < links; ++i) {
      const double distance =
          result.report.bodies[i - 1].pose.position.z() - result.report.bodies[i].pose.position.z();
      off = std::max(off, std::abs(distance - kPitch - sags[i]) / result.voxel);
      aside = std::max(aside, result.aside(i));
    }
    return std::vector<Rule>{{off, kInPlace, "joint error [voxels]"},
                             {aside, kInPlace, "sideways [voxels]"},
                             penetrationRule(result),
                             energyRule(result)};
  });
}

constexpr double kBallRadius = 0.5, kBallMass = 2000,
                 kArm = 1.1;  // from the last link's middle to the ball

SceneBody wreckingBall(const Trial& trial, const Pose& link) {
  SceneBody ball = sphereBody(trial, kBallRadius, link, kBallMass, 0.4);
  ball.collisions[0].pose.position = Vec3(0, -kArm, 0);
  ball.collisions.push_back({"link", Pose(), SceneMesh{"link", Vec3::Ones(), linkMesh()}});
  return ball;
}

// A ball of 2 t on links of a fiftieth of its mass, released at 60 deg, hits three stacked boxes.
// At 7.8 m/s it can be as deep as it moves in one step before a method first sees it.
Verdict wrecking(const Trial& trial) {
  needsHoles(trial);
  constexpr int kLinks = 6;
  constexpr double kHeight = 8;
  Plan plan;
  plan.voxel = 0.04;
  plan.seconds = 2;
  plan.instants = 20;
  plan.spring = springFor(kLinkMass / 2, 2 * kBallMass, 0.1 * plan.voxel);
  // Rotates the links' long axis, y, upright and then back by 60 deg.
  const Eigen::Quaterniond hung =
      Eigen::AngleAxisd(kPi / 3, Vec3::UnitY()) * Eigen::AngleAxisd(kPi / 2, Vec3::UnitX());
  auto& bodies = plan.scene.bodies;
  hang(bodies, hung, Vec3(0, 0, kHeight), kLinks, std::vector<double>(kLinks, 0.0));
  const Vec3 end = bodies.back().pose.position - kPitch * (hung * Vec3::UnitY());
  bodies.push_back(wreckingBall(trial, {hung, end}));
  bodies.push_back(floorBody(kFriction));
  for (const double z : {0.5, 1.5, 2.5})
    bodies.push_back(boxBody(trial, Vec3::Ones(), {Eigen::Quaterniond::Identity(), {1.1, 0, z}},
                             200, kFriction));
  double stretch = 0;
  plan.observe = [&stretch](double, const World& world) {
    for (int i = 1; i <= kLinks; ++i)
      stretch =
          std::max(stretch, (world.pose(i).position - world.pose(i - 1).position).norm() - kPitch);
  };
  const double fall = (kLinks * kPitch + kArm) * (1 - std::cos(kPi / 3));
  return judged(trial, plan, [&](const RunResult& result) {
    const double way = std::sqrt(2 * kGravity * fall) * trial.step / result.voxel;
    const bool struck = result.moved(kLinks + 3) > 5;
    return std::vector<Rule>{{stretch / result.voxel, kInPlace, "joint stretch [voxels]"},
                             {result.deepest(), std::max(kInPlace, way), "penetration [voxels]"},
                             {struck ? 0.0 : 1.0, 0, "boxes not hit"},
                             energyRule(result)};
  });
}

// Rules for bodies that must be at rest at the end.
std::vector<Rule> settled(const RunResult& result) {
  double fastest = 0;
  for (const BodyState& body : result.report.bodies)
    fastest = std::max(fastest, body.linearVelocity.norm());
  return {penetrationRule(result),
          {fastest / result.voxel, kInPlace, "still moves [voxels/s]"},
          energyRule(result)};
}

// A small rotation about the vertical, different for each body.
Eigen::Quaterniond unevenTurn(int body, double upTo) {
  const double turn = (body * 37 % 13 - 6) / 6.0 * upTo;
  return Eigen::Quaterniond(Eigen::AngleAxisd(turn, Vec3::UnitZ()));
}

// Cubes of 1 m in six layers of 6 x 6. Every other layer is shifted by a quarter, so most cubes
// rest on two; each is rotated slightly about the vertical. They drop a little and must come to
// rest.
Verdict pile(const Trial& trial) {
  constexpr int kSide = 6;
  constexpr double kBeside = 1.2, kAbove = 1.01;
  Plan plan;
  plan.voxel = 0.2;
  plan.seconds = 2;
  plan.instants = 10;
  plan.many = true;
  plan.spring = springFor(1000, kSide * 1000, 0.05 * plan.voxel);
  plan.scene.bodies.push_back(floorBody(kFriction));
  for (int i = 0; i < kSide * kSide * kSide; ++i) {
    const int layer = i / kSide / kSide;
    const Vec3 at(kBeside * (i % kSide + 0.25 * (layer % 2)), kBeside * (i / kSide % kSide),
                  0.51 + kAbove * layer);
    plan.scene.bodies.push_back(
        boxBody(trial, Vec3::Ones(), {unevenTurn(i, kPi / 180), at}, 1000, kFriction));
  }
  return judged(trial, plan, settled);
}

// Chain links in ten layers of four, every other layer turned a quarter so that wires cross:
// concave bodies resting on each other.
Verdict linkPile(const Trial& trial) {
  constexpr int kLayers = 10;
  constexpr double kThick = 2 * 0.1, kGap = 1e-3;
  // Spaced so that each link's middle is between the two wires that carry it.
  constexpr double kLong = 1.35, kWide = 1.2;
  const auto mesh = linkMesh();
  Plan plan;
  plan.voxel = 0.04;
  plan.seconds = 2;
  plan.instants = 10;
  plan.many = true;
  plan.spring = springFor(kLinkMass, kLayers * kLinkMass, 0.05 * plan.voxel);
  plan.scene.bodies.push_back(floorBody(kFriction));
  for (int i = 0; i < 4 * kLayers; ++i) {
    const int layer = i / 4;
    const Eigen::Quaterniond lie(Eigen::AngleAxisd(layer % 2 * kPi / 2, Vec3::UnitZ()));
    const Vec3 place((i % 2 - 0.5) * kWide, (i / 2 % 2 - 0.5) * kLong, 0);
    const Vec3 at = lie * place + (kThick / 2 + kGap + (kThick + kGap) * layer) * Vec3::UnitZ();
    plan.scene.bodies.push_back(
        meshBody("link", mesh, {lie * unevenTurn(i, kPi / 180), at}, kLinkMass, kFriction));
  }
  return judged(trial, plan, settled);
}

// A minute of rest without deactivation, after a second for settling.
Verdict rest(const Trial& trial, const std::vector<Vec3>& places) {
  Plan plan;
  plan.voxel = 0.1;
  plan.seconds = 60;
  plan.instants = 10;
  plan.spring = springFor(1000, 3000, 0.1 * plan.voxel);
  plan.scene.bodies.push_back(floorBody(kFriction));
  for (const Vec3& place : places)
    plan.scene.bodies.push_back(
        boxBody(trial, Vec3::Ones(), {Eigen::Quaterniond::Identity(), place}, 1000, kFriction));
  std::vector<Pose> settled;
  plan.observe = [&](double time, const World& world) {
    if (time < 1 || !settled.empty()) return;
    for (std::size_t i = 0; i < world.bodyCount(); ++i) settled.push_back(world.pose(i));
  };
  return judged(trial, plan, [&](const RunResult& result) {
    double drift = 0, turned = 0;
    for (std::size_t i = 1; i < settled.size(); ++i) {
      const Pose& now = result.report.bodies[i].pose;
      drift = std::max(drift, (now.position - settled[i].position).norm() / result.voxel);
      turned = std::max(turned, now.orientation.angularDistance(settled[i].orientation));
    }
    // A tenth of a voxel in a minute.
    return std::vector<Rule>{{drift, 0.1, "drift [voxels]"},
                             {turned * 180 / kPi, 0.2 * turnLimit(result.voxel, 0.5), "tilt [deg]"},
                             penetrationRule(result),
                             energyRule(result)};
  });
}

const std::vector<Method> kAll = {Method::Cloud,   Method::Paper, Method::Primitive,
                                  Method::Gimpact, Method::Hacd,  Method::Gjk};
const std::vector<Method> kMeshes = {Method::Cloud, Method::Paper, Method::Gimpact, Method::Hacd,
                                     Method::Gjk};
const std::vector<double> kSteps = {1.0 / 60, 1.0 / 240, 1.0 / 1000};
const std::vector<std::string> kModes = {"auto", "stiff"};

}  // namespace

std::vector<StabilityScene> stackScenes() {
  const std::vector<double> longer = {1.0 / 60, 1.0 / 240};
  const std::vector<Vec3> three = {{0, 0, 0.5}, {0, 0, 1.5}, {0, 0, 2.5}};
  const std::vector<Vec3> pyramid = {{-1.1, 0, 0.5},  {0, 0, 0.5},    {1.1, 0, 0.5},
                                     {-0.55, 0, 1.5}, {0.55, 0, 1.5}, {0, 0, 2.5}};
  const auto make = [](const char* name, const char* rule, std::vector<Method> methods,
                       std::vector<double> steps, double cost,
                       std::function<Verdict(const Trial&)> run) {
    return StabilityScene{name, "stacks", rule, methods, steps, kModes, cost, std::move(run)};
  };
  const auto timed = [](StabilityScene scene) {
    scene.timed = true;
    return scene;
  };
  const char* stands = "drift [voxels]; tilt, penetration, no energy gained";
  return {
      make("stack of 10", stands, kAll, kSteps, 1, [](const Trial& t) { return stack(t, 10, 5); }),
      make("stack of 20", stands, kAll, kSteps, 2, [](const Trial& t) { return stack(t, 20, 3); }),
      make("card house", stands, kAll, kSteps, 1, cardHouse),
      make("arch", stands, kMeshes, kSteps, 1, arch),
      make("1000 on 1", "penetration [voxels]; tilt, drift, no energy gained", kAll, kSteps, 1,
           heavyOnLight),
      timed(make("chain of 10",
                 "joint error [voxels]; sideways drift, penetration, no energy gained", kMeshes,
                 kSteps, 1, [](const Trial& t) { return chain(t, 10, 3); })),
      make("chain of 30", "joint error [voxels]; sideways drift, penetration, no energy gained",
           kMeshes, kSteps, 2, [](const Trial& t) { return chain(t, 30, 2); }),
      make("wrecking ball", "joint stretch [voxels]; penetration, no energy gained",
           {Method::Cloud, Method::Paper, Method::Gimpact, Method::Gjk}, kSteps, 5, wrecking),
      make("pile of 216", "penetration [voxels]; at rest, no energy gained",
           {Method::Cloud, Method::Paper, Method::Primitive, Method::Gimpact, Method::Gjk}, longer,
           8, pile),
      timed(make("pile of 40 links", "penetration [voxels]; at rest, no energy gained",
                 {Method::Cloud, Method::Paper, Method::Gimpact, Method::Hacd, Method::Gjk}, longer,
                 8, linkPile)),
      make("60 s of rest, stack of 3", "drift [voxels]; tilt, penetration, no energy gained", kAll,
           longer, 1, [=](const Trial& t) { return rest(t, three); }),
      make("60 s of rest, pile of 6", "drift [voxels]; tilt, penetration, no energy gained", kAll,
           longer, 5, [=](const Trial& t) { return rest(t, pyramid); }),
  };
}

}  // namespace cloudcontact::program::lab
