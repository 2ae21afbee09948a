// Bodies that slide 10 m over a terrain of 200,000 triangles, by a btBvhTriangleMeshShape and a
// btHeightfieldTerrainShape, without friction: as clouds and as GImpact meshes. Speeds where the
// terrain is flat, energy and depth; processor time of one thread a step, in one run. As GImpact
// bodies stop or fall through, each is also put, step by step, where the cloud was.
//
// slides [mesh file, which takes the place of the humped ball, or -] [one body] [no: GImpact is
// left out]
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <cloudcontact/mesh/mesh_file.h>

#include <cstdio>

#include "bullet/slide_course.h"
#include "timing.h"

namespace {

using namespace cloudcontact;
using namespace cloudcontact::testing;

constexpr double kForever = 1e9;  // [s]

void print(const char* body, const char* ground, const char* method, const Slide& s) {
  std::printf("%-5s %-11s %-8s %5d %8.3f | %7.4f %7.4f %7.4f %7.4f | %9.2e %9.2e %9.5f\n", body,
              ground, method, s.steps, 1e3 * s.seconds / s.steps, s.bumps / s.start,
              std::min(9.0, s.slowest / s.start), s.flat / s.start, s.end / s.flat, s.gained,
              0.5 * s.weight * s.sag, s.deepest);
  std::fflush(stdout);
}

// A world's steps with a body that is put where another was in each: the same work.
double secondsAlong(const std::vector<Moment>& way, CourseWorld& world, btRigidBody& body) {
  double seconds = 0;
  for (const Moment& m : way) {
    body.setWorldTransform(m.place);
    body.setInterpolationWorldTransform(m.place);
    body.setLinearVelocity(m.speed);
    body.setAngularVelocity(m.spin);
    const double before = threadSeconds();
    world.step(kCourseStep);
    seconds += threadSeconds() - before;
  }
  return seconds;
}

void compare(const Slider& slider, Course& course, bool gimpact) {
  CloudBody cloud(slider.mesh);
  const std::vector<Vec3> vertices = verticesOf(slider, cloud);
  std::vector<Moment> way;
  double step = 0;
  {
    CourseWorld world(course);
    world.start(cloud.body(), vertices);
    const Slide s = slide(world, cloud.body(), vertices, threadSeconds, kForever, &way);
    print(slider.name.c_str(), course.name, "cloud", s);
    step = s.seconds / s.steps;
  }
  if (!gimpact || course.ground.shape->getShapeType() == STATIC_PLANE_PROXYTYPE) return;
  Mesh mesh = slider.mesh;
  mesh.vertices = vertices;
  Kept kept = gimpactShape(mesh);
  kept.shape->setMargin(btScalar(0.001));
  static_cast<btGImpactMeshShape&>(*kept.shape).updateBound();
  btRigidBody body(cloud.body().getMass(), nullptr, kept.shape.get(),
                   cloud.body().getLocalInertia());
  {
    CourseWorld world(course);
    btGImpactCollisionAlgorithm::registerAlgorithm(&world.dispatcher);
    world.start(body, vertices);
    constexpr double kAtMost = 20;  // [s]
    print(slider.name.c_str(), course.name, "gimpact",
          slide(world, body, vertices, threadSeconds, kAtMost));
  }
  CourseWorld world(course);
  btGImpactCollisionAlgorithm::registerAlgorithm(&world.dispatcher);
  world.start(body, vertices);
  const double gimpactStep = secondsAlong(way, world, body) / double(way.size());
  std::printf("%-5s %-11s gimpact along the cloud's way: %.3f ms a step, %.2f times the cloud's\n",
              slider.name.c_str(), course.name, 1e3 * gimpactStep, gimpactStep / step);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<Slider> bodies = sliders();
  if (argc > 1 && argv[1][0] != '-') {
    Slider& last = bodies.back();
    last = {"file", loadMesh(argv[1])};
    Eigen::AlignedBox3d box;
    for (const Vec3& v : last.mesh.vertices) box.extend(v);
    for (Vec3& v : last.mesh.vertices) v *= 0.2 / box.sizes().maxCoeff();
  }
  std::printf(
      "body  ground      method   steps  ms/step | speed: to bumps, slowest, over bumps, "
      "last part | energy gained [J], of the spring at rest, deepest [m]\n");
  std::vector<Course> courses = terrains();
  courses.push_back(planeCourse());
  for (Course& course : courses)
    for (const Slider& slider : bodies)
      if (argc < 3 || slider.name == argv[2]) compare(slider, course, argc < 4);
}
