// Bullet's rays and sweeps on six clouds, beside the same meshes in a btBvhTriangleMeshShape: time
// a query, in one run. They take turns in rounds; medians and ratios are printed.
//
// queries [triangle's edge in voxels] [mesh file, voxels across]
#include <cloudcontact/mesh/mesh_file.h>

#include <cstdio>
#include <cstdlib>

#include "bullet/query_bodies.h"
#include "timing.h"

namespace {

using namespace cloudcontact;
using namespace cloudcontact::testing;

constexpr int kRounds = 7, kRays = 2000, kSweeps = 60;

std::vector<Segment> segments(int count, double radius, double reach) {
  Random random(7);
  std::vector<Segment> all;
  for (int i = 0; i < count; ++i) all.push_back(randomSegment(random, radius, reach));
  return all;
}

double rays(const btCollisionWorld& world, double radius, double reach) {
  const std::vector<Segment> all = segments(kRays, radius, reach);
  const double start = threadSeconds();
  for (const auto& [from, to] : all) {
    btCollisionWorld::ClosestRayResultCallback hit(from, to);
    world.rayTest(from, to, hit);
  }
  return (threadSeconds() - start) / kRays;
}

double sweeps(const btCollisionWorld& world, const btConvexShape& shape, double radius,
              double reach) {
  Random random(7);
  const double start = threadSeconds();
  for (int i = 0; i < kSweeps; ++i) {
    const auto [from, to] = randomSegment(random, radius, reach);
    const btQuaternion turn(btVector3(1, 2, 3), btScalar(i));
    btCollisionWorld::ClosestConvexResultCallback hit(from, to);
    world.convexSweepTest(&shape, btTransform(turn, from), btTransform(turn, to), hit);
  }
  return (threadSeconds() - start) / kSweeps;
}

void compare(const QueryBody& body) {
  QueryWorld cloud(body, true), mesh(body, false);
  const double reach = body.radius / 4;
  const btSphereShape ball(btScalar(reach / 3));
  const btBoxShape box(btVector3(btScalar(reach / 2), btScalar(reach / 3), btScalar(reach / 4)));
  const btCapsuleShape capsule(btScalar(reach / 4), btScalar(reach / 2));
  const btConvexShape* const shapes[] = {&ball, &box, &capsule};
  std::vector<double> times[2][4];
  for (int round = 0; round < kRounds; ++round)
    for (int i = 0; i < 2; ++i) {
      const btCollisionWorld& world = (i == 0 ? cloud : mesh).scene.world;
      times[i][0].push_back(rays(world, body.radius, reach));
      for (int k = 0; k < 3; ++k)
        times[i][k + 1].push_back(sweeps(world, *shapes[k], body.radius, reach));
    }
  std::printf("%-8s %9zu", body.name.c_str(), body.mesh.triangles.size());
  for (int k = 0; k < 4; ++k) {
    const double own = median(times[0][k]), other = median(times[1][k]);
    std::printf(" | %8.2f %8.2f %6.2f", 1e6 * own, 1e6 * other, own / other);
  }
  std::printf("\n");
}

}  // namespace

int main(int argc, char** argv) {
  const double facet = argc > 1 ? std::atof(argv[1]) : 1;
  std::printf("%-8s %9s | rays: cloud, mesh [us], ratio | balls swept | boxes | capsules\n", "body",
              "triangles");
  if (argc > 3) {
    QueryBody body{"file", loadMesh(argv[2]), nullptr, 0};
    Eigen::AlignedBox3d box;
    for (const Vec3& v : body.mesh.vertices) box.extend(v);
    const double scale = 4 / box.sizes().maxCoeff();
    for (Vec3& v : body.mesh.vertices) v = scale * (v - box.center());
    for (const Vec3& v : body.mesh.vertices) body.radius = std::max(body.radius, v.norm());
    body.field = fieldOf(body.mesh, 4 / std::atof(argv[3]));
    compare(body);
    return 0;
  }
  for (const QueryBody& body : queryBodies(facet)) compare(body);
  return 0;
}
