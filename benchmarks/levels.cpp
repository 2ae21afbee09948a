// A nut on a bolt among loose bodies that lie and roll on a floor: all with voxels as fine as the
// thread needs, and with levels (CloudShape::setFidelity). Two worlds go step by step in one run.
//   levels [--bodies N] [--kinds N] [--seconds S] [--voxel H] [--tolerance T] [--budget S]
// Processor time of the narrow phase on one thread, memory of fields and clouds, and how far apart
// the two worlds end.
#include <btBulletDynamicsCommon.h>
#include <cloudcontact/bullet/cloud_contact.h>
#include <cloudcontact/bullet/cloud_dispatcher.h>
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/bullet/newton_solver.h>
#include <cloudcontact/voxels/digitize.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "command.h"
#include "mesh/thread_meshes.h"
#include "scene/generated_mesh.h"
#include "scene/primitive_mesh.h"
#include "timing.h"

namespace {

using namespace cloudcontact;

struct Options {
  int bodies = 200, kinds = 20;
  double seconds = 1, voxel = 0.2e-3, tolerance = 0.1e-3, budget = 0, step = 1. / 240;
  double friction = 0;  // of the nut; its thread holds from 0.037 on
  double speed = 0.2;
  int settle = 24;  // steps before the clock starts
  bool reports = false;
};

constexpr double kDensity = 7800, kPlay = 0.1e-3, kNut = 13e-3, kBolt = 40e-3, kPitch = 60e-3;

btScalar s(double x) {
  return static_cast<btScalar>(x);
}

// A loose body's mesh, about its center, and how it lies: the height of its center, and whether it
// rolls along x.
struct Kind {
  const char* name;
  Mesh mesh;
  double height;
  bool rolls;
};

Mesh stretched(Mesh mesh, const Vec3& by) {
  for (Vec3& v : mesh.vertices) v = v.cwiseProduct(by);
  return mesh;
}

// About its middle, the axis from z to y.
Mesh lying(Mesh mesh, double length) {
  for (Vec3& v : mesh.vertices) v = Vec3(v.x(), v.z() - length / 2, -v.y());
  return mesh;
}

// `size`: 0.8 to 1.2.
Kind kindOf(int index, double size) {
  constexpr double kFine = 1e-6;
  const auto primitive = [&](const Solid& solid) { return program::primitiveMesh(solid, kFine); };
  const double mm = 1e-3 * size;
  switch (index % 10) {
    case 0:
      return {"ball", primitive(Sphere{9 * mm}), 9 * mm, true};
    case 1:
      return {"box", primitive(Box{{10 * mm, 8 * mm, 6 * mm}}), 6 * mm, false};
    case 2:
      return {"roller", lying(primitive(Cylinder{8 * mm, 10 * mm}), 0), 8 * mm, true};
    case 3:
      return {"disc", primitive(Cylinder{11 * mm, 5 * mm}), 5 * mm, false};
    case 4:
      return {"capsule", lying(primitive(Capsule{7 * mm, 8 * mm}), 0), 7 * mm, true};
    case 5:
      return {"egg", stretched(primitive(Sphere{8 * mm}), {1, 1.4, 1}), 8 * mm, true};
    case 6:
      return {"peg", lying(program::pegMesh(7 * mm, 24 * mm, 1.5 * mm), 24 * mm), 7 * mm, true};
    case 7:
      return {"link", program::chainLinkMesh({4 * mm, 10 * mm, 8 * mm, 48, 64}), 4 * mm, false};
    case 8:
      return {"ring",
              revolvedMesh(120, 60, true,
                           [&](double angle, double s) {
                             const double t = 2 * std::numbers::pi * s, r = 9 + 4 * std::cos(t);
                             return Vec3(r * mm * std::cos(angle), r * mm * std::sin(angle),
                                         4 * mm * std::sin(t));
                           }),
              4 * mm, false};
    default:
      return {"cube", primitive(Box{{8 * mm, 8 * mm, 8 * mm}}), 8 * mm, false};
  }
}

// The same bodies in both worlds.
struct Part {
  std::string name;
  Cloud cloud;
  double mass;
  btVector3 inertia;
};

Part partOf(const std::string& name, const Mesh& mesh, double voxel) {
  DigitizeSettings how;
  how.voxelSize = voxel;
  how.threads = 1;
  Part part{name, digitize(mesh, how), 0, {}};
  const MassProperties matter = part.cloud.massProperties();
  part.mass = kDensity * matter.mass;
  const Vec3 inertia = kDensity * matter.inertia.diagonal();
  part.inertia = {s(inertia.x()), s(inertia.y()), s(inertia.z())};
  return part;
}

class TimedDispatcher : public CloudDispatcher {
 public:
  using CloudDispatcher::CloudDispatcher;
  void dispatchAllCollisionPairs(btOverlappingPairCache* pairs, const btDispatcherInfo& info,
                                 btDispatcher* dispatcher) override {
    const double start = threadSeconds();
    CloudDispatcher::dispatchAllCollisionPairs(pairs, info, dispatcher);
    seconds += threadSeconds() - start;
  }
  double seconds = 0;
};

class World {
 public:
  World(const CloudContactSettings& settings)
      : contact_(settings), dispatcher(&configuration_, CloudDispatcherSettings{.threads = 1}) {
    gContactBreakingThreshold = gDbvtMargin = s(1e-3);
    contact_.attach(dispatcher);
    recommendedSettings(world_);
    world_.getSolverInfo().m_minimumSolverBatchSize = 1;
    world_.setGravity({0, 0, s(-9.81)});
    add(std::make_shared<btStaticPlaneShape>(btVector3(0, 0, 1), 0), 0, {0, 0, 0},
        btTransform::getIdentity());
  }
  ~World() {
    for (auto& body : bodies) world_.removeRigidBody(body.get());
  }
  btRigidBody& add(std::shared_ptr<btCollisionShape> shape, double mass, const btVector3& inertia,
                   const btTransform& place) {
    btRigidBody::btRigidBodyConstructionInfo info(s(mass), nullptr, shape.get(), inertia);
    info.m_startWorldTransform = place;
    info.m_friction = s(0.4);
    shapes_.push_back(std::move(shape));
    bodies.push_back(std::make_unique<btRigidBody>(info));
    bodies.back()->setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(bodies.back().get());
    return *bodies.back();
  }
  void step(double seconds) {
    const double start = threadSeconds();
    world_.stepSimulation(s(seconds), 0);
    stepSeconds += threadSeconds() - start;
  }
  const CloudContact& contact() const { return contact_; }
  double energy() const {
    double sum = 0;
    for (const auto& body : bodies) {
      if (!(body->getInvMass() > 0)) continue;
      const double mass = 1 / double(body->getInvMass());
      const btVector3 w =
          body->getWorldTransform().getBasis().transpose() * body->getAngularVelocity();
      sum += 0.5 * mass * double(body->getLinearVelocity().length2()) +
             0.5 * double((w * body->getLocalInertia()).dot(w)) +
             9.81 * mass * double(body->getWorldTransform().getOrigin().z());
    }
    return sum;
  }

 private:
  CloudContact contact_;
  btDefaultCollisionConfiguration configuration_;

 public:
  TimedDispatcher dispatcher;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  double stepSeconds = 0;

 private:
  btDbvtBroadphase broadphase_;
  NewtonSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher, &broadphase_, &solver_, &configuration_};
  std::vector<std::shared_ptr<btCollisionShape>> shapes_;
};

// One world, its shapes, and what they hold.
struct Scene {
  std::unique_ptr<World> world;
  std::vector<std::shared_ptr<const FieldLevels>> levels;
  btRigidBody* nut = nullptr;
  double buildSeconds = 0, turned = 0;
  std::vector<double> micros;  // of each step's narrow phase
  std::vector<btVector3> starts;
  std::vector<PairReport> before;  // when the clock started
  int settle = 0;
  double firstSeconds = 0;  // of the steps before that

  std::size_t bytes() const {
    std::size_t sum = 0;
    for (const auto& one : levels) sum += one->bytes();
    return sum;
  }
  std::size_t cloudBytes() const {
    std::size_t sum = 0;
    for (const auto& one : levels) sum += one->cloud().bytes();
    return sum;
  }
};

Scene sceneOf(const Options& options, const std::vector<Part>& parts,
              const std::vector<Kind>& kinds, double tolerance) {
  Scene scene;
  CloudContactSettings settings;
  settings.bears = 100;
  settings.fidelity.tolerance = tolerance;
  if (tolerance > 0) settings.fidelity.budget = options.budget;
  scene.world = std::make_unique<World>(settings);
  FieldSettings how;
  how.threads = 1;
  std::vector<std::shared_ptr<CloudShape>> shapes;
  const double start = threadSeconds();
  for (const Part& part : parts) {
    scene.levels.push_back(std::make_shared<const FieldLevels>(part.cloud, how));
    shapes.push_back(std::make_shared<CloudShape>(scene.levels.back()));
    if (tolerance > 0)
      shapes.back()->setFidelity({tolerance});
    else
      shapes.back()->field();
  }
  scene.buildSeconds = threadSeconds() - start;
  const auto at = [](double x, double y, double z) {
    return btTransform(btQuaternion::getIdentity(), {s(x), s(y), s(z)});
  };
  World& world = *scene.world;
  btRigidBody& bolt = world.add(shapes[0], 0, {0, 0, 0}, at(0, 0, kBolt / 2));
  bolt.setFriction(s(options.friction));
  scene.nut = &world.add(shapes[1], parts[1].mass, parts[1].inertia, at(0, 0, kBolt / 2 + 8e-3));
  scene.nut->setFriction(1);
  // Each kind in a lane of its own, so that what rolls meets nothing.
  for (int i = 0; i < options.bodies; ++i) {
    const std::size_t lane = static_cast<std::size_t>(i) % kinds.size(), k = lane;
    const double x = kPitch * (i / static_cast<int>(kinds.size()) + 1),
                 y = kPitch * (static_cast<double>(lane) - 0.5 * static_cast<double>(kinds.size()));
    btRigidBody& body = world.add(shapes[k + 2], parts[k + 2].mass, parts[k + 2].inertia,
                                  at(x, y, kinds[k].height));
    if (kinds[k].rolls) {
      body.setLinearVelocity({s(options.speed), 0, 0});
      body.setAngularVelocity({0, s(options.speed / kinds[k].height), 0});
    }
  }
  for (const auto& body : world.bodies)
    scene.starts.push_back(body->getWorldTransform().getOrigin());
  scene.settle = options.settle;
  return scene;
}

void step(Scene& scene, double seconds) {
  const double before = scene.world->dispatcher.seconds;
  scene.world->step(seconds);
  scene.micros.push_back(1e6 * (scene.world->dispatcher.seconds - before));
  scene.turned += seconds * double(scene.nut->getAngularVelocity().z());
}

void tell(const char* name, const Scene& scene, double start) {
  const World& world = *scene.world;
  const CloudContactStatistics made = world.contact().statistics();
  const double steps = double(scene.micros.size()), all = steps + double(scene.settle);
  double mean = 0;
  for (const double m : scene.micros) mean += m / steps;
  std::printf(
      "%-8s narrow %8.1f us a step (median %.1f, worst %.0f), step %8.1f us; memory %.2f MB, of it "
      "%.2f of finest clouds; %.2f s before the first step, the first steps %.2f s; energy %+.3g "
      "J; "
      "nut at %.4f mm, turned %.4f rad; %zu failures\n",
      name, mean, median(scene.micros), *std::max_element(scene.micros.begin(), scene.micros.end()),
      1e6 * world.stepSeconds / steps, 1e-6 * double(scene.bytes()),
      1e-6 * double(scene.cloudBytes()), scene.buildSeconds, scene.firstSeconds,
      world.energy() - start, 1e3 * double(scene.nut->getWorldTransform().getOrigin().z()),
      scene.turned, made.failures);
  std::printf("         %.1f pairs a step, %.1f by shapes, %.1f coarser, %zu refined, %zu eased\n",
              double(made.pairs) / all, double(made.shapes) / all, double(made.coarser) / all,
              made.refined, made.eased);
}

// How far apart the bodies of a kind are in the two worlds, and the time of its pairs.
void compare(const Scene& fine, const Scene& coarse, const std::vector<Kind>& kinds) {
  const auto seconds = [](const Scene& scene) {
    std::map<const btCollisionObject*, double> sums;
    for (const PairReport& pair : scene.before)
      for (const btCollisionObject* body : {pair.a, pair.b}) sums[body] -= pair.seconds;
    for (const PairReport& pair : scene.world->contact().pairs())
      for (const btCollisionObject* body : {pair.a, pair.b}) sums[body] += pair.seconds;
    return sums;
  };
  const auto ofFine = seconds(fine), ofCoarse = seconds(coarse);
  const auto timeOf = [](const auto& sums, const btCollisionObject* body) {
    const auto found = sums.find(body);
    return found == sums.end() ? 0. : found->second;
  };
  double farthest = 0, highest = 0;
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    double apart = 0, higher = 0, times[2] = {0, 0}, way[2] = {0, 0};
    int bodies = 0;
    for (std::size_t i = 3 + k; i < fine.world->bodies.size(); i += kinds.size(), ++bodies) {
      const btVector3 d = coarse.world->bodies[i]->getWorldTransform().getOrigin() -
                          fine.world->bodies[i]->getWorldTransform().getOrigin();
      apart = std::max(apart, double(d.length()));
      higher = std::max(higher, std::abs(double(d.z())));
      const btVector3 start = fine.starts[i];
      way[0] = double((fine.world->bodies[i]->getWorldTransform().getOrigin() - start).x());
      way[1] = double((coarse.world->bodies[i]->getWorldTransform().getOrigin() - start).x());
      times[0] += timeOf(ofFine, fine.world->bodies[i].get());
      times[1] += timeOf(ofCoarse, coarse.world->bodies[i].get());
    }
    const double per = 1e6 / double(std::max(1, bodies)) / double(fine.micros.size());
    std::printf(
        "  %-8s %6.2f us fine, %6.2f us levels; apart %.4f mm, in height %.4f mm; moved "
        "%.2f and %.2f mm\n",
        kinds[k].name, per * times[0], per * times[1], 1e3 * apart, 1e3 * higher, 1e3 * way[0],
        1e3 * way[1]);
    farthest = std::max(farthest, apart);
    highest = std::max(highest, higher);
  }
  std::printf("  %-8s %6.2f us fine, %6.2f us levels\n", "nut",
              1e6 * timeOf(ofFine, fine.nut) / double(fine.micros.size()),
              1e6 * timeOf(ofCoarse, coarse.nut) / double(fine.micros.size()));
  std::printf("loose bodies end %.4f mm apart at most, %.4f mm in height\n", 1e3 * farthest,
              1e3 * highest);
}

void measure(const Options& options) {
  std::vector<Kind> kinds;
  for (int k = 0; k < options.kinds; ++k)
    kinds.push_back(kindOf(k, 0.8 + 0.4 * k / std::max(1, options.kinds - 1)));
  const Thread thread;
  std::vector<Part> parts{partOf("bolt", threadedRod(thread, kBolt), options.voxel),
                          partOf("nut", threadedRing(thread, kNut, 12e-3, kPlay), options.voxel)};
  for (const Kind& kind : kinds) parts.push_back(partOf(kind.name, kind.mesh, options.voxel));
  Scene fine = sceneOf(options, parts, kinds, 0);
  Scene coarse = sceneOf(options, parts, kinds, options.tolerance);
  const double start[2] = {fine.world->energy(), coarse.world->energy()};
  for (Scene* scene : {&fine, &coarse}) {
    for (int i = 0; i < options.settle; ++i) scene->world->step(options.step);
    scene->before = scene->world->contact().pairs();
    scene->firstSeconds = std::exchange(scene->world->dispatcher.seconds, 0);
    scene->world->stepSeconds = 0;
  }
  for (int i = 0; i < options.seconds / options.step; ++i)
    for (Scene* scene : {&fine, &coarse}) step(*scene, options.step);
  tell("fine", fine, start[0]);
  tell("levels", coarse, start[1]);
  compare(fine, coarse, kinds);
  double narrow[2] = {0, 0};
  for (std::size_t i = 0; i < fine.micros.size(); ++i)
    narrow[0] += fine.micros[i], narrow[1] += coarse.micros[i];
  std::printf(
      "ratio of narrow phases %.3f (medians %.3f), of memory %.3f, without clouds %.3f\n",
      narrow[1] / narrow[0], median(coarse.micros) / median(fine.micros),
      double(coarse.bytes()) / double(fine.bytes()),
      double(coarse.bytes() - coarse.cloudBytes()) / double(fine.bytes() - fine.cloudBytes()));
  if (!options.reports) return;
  for (const Scene* scene : {&fine, &coarse})
    for (const PairReport& pair : scene->world->contact().pairs())
      std::printf(
          "pair: voxels %.3g %.3g mm, level %d %d, expected error %.4f mm, depth %.4f mm, %zu "
          "searched, %zu coarser, %zu refined, %.0f lookups, %.2f us\n",
          1e3 * pair.voxel[0], 1e3 * pair.voxel[1], pair.voxelLevel[0], pair.voxelLevel[1],
          1e3 * pair.expectedError, 1e3 * pair.depth, pair.searched, pair.coarser, pair.refined,
          double(pair.work.samples) / double(std::max<std::size_t>(1, pair.searched)),
          1e6 * pair.seconds / double(pair.answers()));
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App words("A nut on a bolt among loose bodies, by levels", "levels");
  words.add_option("--bodies", options.bodies);
  words.add_option("--kinds", options.kinds, "of loose bodies, each with its own voxels");
  words.add_option("--seconds", options.seconds);
  words.add_option("--step", options.step, "[s]");
  words.add_option("--voxel", options.voxel, "[m] the finest");
  words.add_option("--tolerance", options.tolerance, "[m]");
  words.add_option("--budget", options.budget, "[s per step] of the world with levels");
  words.add_option("--settle", options.settle, "steps before the clock starts");
  words.add_option("--friction", options.friction, "of nut and bolt");
  words.add_option("--speed", options.speed, "[m/s] of bodies that roll");
  words.add_flag("--reports", options.reports, "each pair's");
  return runCommand(words, argc, argv, [&options] { measure(options); });
}
