// A course of 10 m along x, over a terrain that is flat at both ends and has bumps between, and
// bodies that slide along it without friction.
#pragma once

// First: Bullet's soft bodies declare a global named seed.
#include "bullet/dispatch_stage.h"

#include <cloudcontact/bullet/cloud_body.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "bullet/query_bodies.h"
#include "bullet/triangle_grounds.h"

namespace cloudcontact::testing {

// [m] Flat from 0 to kBumpsFrom and from kBumpsTo to kCourse.
constexpr double kBumpsFrom = 3, kBumpsTo = 7, kCourse = 10;
constexpr double kBeyond = 1;              // of the terrain before the start and after the end [m]
constexpr double kCourseWidth = 4.8;       // [m]
constexpr double kCourseSpeed = 2;         // [m/s] at the start
constexpr double kCourseStep = 1 / 240.0;  // [s]
// Squares of 24 mm, two triangles each: 200,000.
constexpr int kSquaresAlong = 500, kSquaresAcross = 200;

// Bumps of 1 cm with slopes up to 0.1, which begin and end smoothly within half a meter.
inline double courseHeight(double x, double y) {
  const auto rise = [](double s) {
    const double t = std::min(std::max(2 * s, 0.0), 1.0);
    return t * t * (3 - 2 * t);
  };
  return 0.01 * rise(x - kBumpsFrom) * rise(kBumpsTo - x) * std::sin(9 * x) * std::cos(7 * y);
}

struct Course {
  const char* name;
  Kept ground;
  btTransform place;
};

inline Vec3 coursePoint(int i, int j) {
  const double x = (kCourse + 2 * kBeyond) * i / kSquaresAlong - kBeyond;
  const double y = kCourseWidth * j / kSquaresAcross - kCourseWidth / 2;
  return {x, y, courseHeight(x, y)};
}

inline Course planeCourse() {
  return {"plane", {std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), 0)}, at({0, 0, 0})};
}

inline Course bvhCourse() {
  Mesh mesh;
  for (int j = 0; j <= kSquaresAcross; ++j)
    for (int i = 0; i <= kSquaresAlong; ++i) mesh.vertices.push_back(coursePoint(i, j));
  constexpr int kRow = kSquaresAlong + 1;
  for (int j = 0; j < kSquaresAcross; ++j)
    for (int i = 0; i < kSquaresAlong; ++i) {
      const int corner = j * kRow + i;
      mesh.triangles.emplace_back(corner, corner + 1, corner + kRow + 1);
      mesh.triangles.emplace_back(corner, corner + kRow + 1, corner + kRow);
    }
  return {"bvh", bvhShape(mesh), at({0, 0, 0})};
}

// Its middle is the middle of the heights.
inline Course heightfieldCourse() {
  auto heights = std::make_shared<std::vector<btScalar>>();
  for (int j = 0; j <= kSquaresAcross; ++j)
    for (int i = 0; i <= kSquaresAlong; ++i) heights->push_back(btScalar(coursePoint(i, j).z()));
  auto shape = std::make_unique<btHeightfieldTerrainShape>(
      kSquaresAlong + 1, kSquaresAcross + 1, heights->data(), btScalar(1), btScalar(-1),
      btScalar(1), 2, PHY_FLOAT, false);
  shape->setLocalScaling({btScalar((kCourse + 2 * kBeyond) / kSquaresAlong),
                          btScalar(kCourseWidth / kSquaresAcross), 1});
  return {"heightfield", {std::move(shape), {heights}}, at({btScalar(kCourse / 2), 0, 0})};
}

struct Slider {
  std::string name;
  Mesh mesh;
};

// A box, a ball, a cup, a nut and, for a cow, a ball with humps: 15 to 20 cm wide.
inline std::vector<Slider> sliders() {
  const auto scaled = [](Mesh mesh, double factor) {
    for (Vec3& v : mesh.vertices) v *= factor;
    return mesh;
  };
  return {{"box", boxMesh({0.2, 0.15, 0.1})},
          {"ball", test::sphereMesh(0.08, 4)},
          {"cup", scaled(cupMesh(1, 64), 0.3)},
          {"nut", plainNut(0.18, 0.1, 0.07)},
          {"cow", scaled(humpedMesh(64, 48), 0.25)}};
}

inline Slider sliderOf(const std::string& name) {
  const std::vector<Slider> all = sliders();
  return *std::ranges::find(all, name, &Slider::name);
}

// The two terrains.
inline std::vector<Course> terrains() {
  std::vector<Course> all;
  all.push_back(bvhCourse());
  all.push_back(heightfieldCourse());
  return all;
}

// In the body's frame.
inline std::vector<Vec3> verticesOf(const Slider& slider, const CloudBody& body) {
  std::vector<Vec3> vertices;
  for (const Vec3& v : slider.mesh.vertices)
    vertices.push_back(fromBt(body.meshToBody() * bullet(v)));
  return vertices;
}

// A world with the course, without friction.
struct CourseWorld : BulletWorld {
  explicit CourseWorld(Course& course) : ground(0, nullptr, course.ground.shape.get()) {
    ground.setWorldTransform(course.place);
    ground.setFriction(0);
    world.addRigidBody(&ground);
  }
  ~CourseWorld() {
    if (body) world.removeRigidBody(body);
    world.removeRigidBody(&ground);
  }
  // Puts the body on the start, a millimeter above the ground.
  void start(btRigidBody& moving, const std::vector<Vec3>& vertices) {
    double lowest = 0;
    for (const Vec3& v : vertices) lowest = std::min(lowest, v.z());
    const btTransform place = at({0, 0, btScalar(1e-3 - lowest)});
    moving.setWorldTransform(place);
    moving.setInterpolationWorldTransform(place);
    moving.setLinearVelocity({0, 0, 0});
    moving.setAngularVelocity({0, 0, 0});
    moving.setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(&moving);
    body = &moving;
  }

  btRigidBody ground;
  btRigidBody* body = nullptr;
};

// What a body did on its way to the end of the course.
struct Slide {
  double start = 0, bumps = 0, flat = 0, end = 0;  // horizontal speed at the parts' borders [m/s]
  double slowest = 1e9;                            // on the bumps
  double gained = -1e9;                            // energy above that at the start, at most [J]
  double ended = 0;                                // the same at the end [J]
  double deepest = -1e9;                           // lowest vertex below the terrain [m]
  double sag = 0;                                  // the same at the start [m]
  double weight = 0;                               // [N]
  double seconds = 0;                              // of processor time in steps
  int steps = 0;
};
constexpr int kMostSteps = 2400;

// With the part of a step's fall that Bullet's way of stepping takes ahead: in free fall it stays
// the same.
inline double energyAbove(const btRigidBody& body) {
  const btVector3 w = body.getAngularVelocity();
  const btMatrix3x3 inertia = body.getInvInertiaTensorWorld().inverse();
  return 0.5 * body.getMass() * body.getLinearVelocity().length2() + 0.5 * w.dot(inertia * w) +
         9.81 * body.getMass() *
             (body.getWorldTransform().getOrigin().z() -
              0.5 * kCourseStep * body.getLinearVelocity().z());
}

// How deep the lowest of `vertices`, in the body's frame, is below the terrain [m].
inline double depthOnCourse(const btRigidBody& body, const std::vector<Vec3>& vertices) {
  double deepest = -1e9;
  for (const Vec3& v : vertices) {
    const btVector3 x = body.getWorldTransform() * bullet(v);
    deepest = std::max(deepest, courseHeight(x.x(), x.y()) - double(x.z()));
  }
  return deepest;
}

inline void watch(Slide& s, const btRigidBody& body, const std::vector<Vec3>& vertices,
                  double startEnergy) {
  const double x = body.getWorldTransform().getOrigin().x();
  const btVector3 v = body.getLinearVelocity();
  const double speed = std::hypot(double(v.x()), double(v.y()));
  constexpr double kReach = 0.15;  // of a body beside its middle
  if (x < kBumpsFrom - kReach) s.bumps = speed;
  if (x < kBumpsTo + kReach) s.flat = speed;
  if (x < kCourse) s.end = speed;
  if (x > kBumpsFrom && x < kBumpsTo) s.slowest = std::min(s.slowest, speed);
  s.ended = energyAbove(body) - startEnergy;
  s.gained = std::max(s.gained, s.ended);
  if (s.steps % 4 == 0) s.deepest = std::max(s.deepest, depthOnCourse(body, vertices));
}

// A body at the begin of a step.
struct Moment {
  btTransform place;
  btVector3 speed, spin;
};

// Rests for half a second, then gets its speed. `clock`: processor time [s]. `way`: gets each
// step's moment.
inline Slide slide(
    CourseWorld& world, btRigidBody& body, const std::vector<Vec3>& vertices,
    const std::function<double()>& clock = [] { return 0.0; }, double secondsAtMost = 1e9,
    std::vector<Moment>* way = nullptr) {
  for (int i = 0; i < 120; ++i) world.step(kCourseStep);
  body.setLinearVelocity({btScalar(kCourseSpeed), 0, 0});
  body.setAngularVelocity({0, 0, 0});
  Slide s;
  s.start = kCourseSpeed;
  s.sag = std::max(0.0, depthOnCourse(body, vertices));
  s.weight = 9.81 * body.getMass();
  const double startEnergy = energyAbove(body);
  while (body.getWorldTransform().getOrigin().x() < kCourse && s.steps < kMostSteps &&
         s.seconds < secondsAtMost) {
    if (way)
      way->push_back(
          {body.getWorldTransform(), body.getLinearVelocity(), body.getAngularVelocity()});
    const double before = clock();
    world.step(kCourseStep);
    s.seconds += clock() - before;
    ++s.steps;
    watch(s, body, vertices, startEnergy);
  }
  return s;
}

}  // namespace cloudcontact::testing
