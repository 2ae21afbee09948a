// The table of docs/bullet.md: each type of shape that Bullet knows has a row or is no shape, and a
// box, a torus and a cup of cloud fall on, under and beside each shape of the table.
#include <BulletCollision/CollisionShapes/btConvexPointCloudShape.h>
#include <BulletCollision/CollisionShapes/btConvexTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btEmptyShape.h>
#include <BulletCollision/CollisionShapes/btMinkowskiSumShape.h>
#include <BulletCollision/CollisionShapes/btMultiSphereShape.h>
#include <BulletCollision/CollisionShapes/btSdfCollisionShape.h>
#include <BulletCollision/CollisionShapes/btTetrahedronShape.h>
#include <BulletCollision/CollisionShapes/btUniformScalingShape.h>
#include <cloudcontact/bullet/diagnosis.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "bullet/triangle_grounds.h"

namespace cloudcontact::testing::shape_table_test {
namespace {

constexpr double kGravity = 9.81;
constexpr int kSteps = 120;  // of 1/240 s

btScalar s(double x) {
  return btScalar(x);
}

Kept hull() {
  auto made = std::make_unique<btConvexHullShape>();
  for (const double x : {-0.1, 0.1})
    for (const double y : {-0.08, 0.08})
      for (const double z : {-0.06, 0.06}) made->addPoint({s(x), s(y), s(z)});
  return {std::move(made)};
}

Mesh block() {
  return test::boxMesh({-0.1, -0.08, -0.06}, {0.1, 0.08, 0.06});
}

Kept convexTriangles() {
  auto triangles = triangleMesh(block());
  return {std::make_unique<btConvexTriangleMeshShape>(triangles.get()), {triangles}};
}

Kept pointCloud() {
  auto points = std::make_shared<std::vector<btVector3>>();
  for (const auto& v : block().vertices) points->push_back(bullet(v));
  return {std::make_unique<btConvexPointCloudShape>(points->data(), int(points->size()),
                                                    btVector3(1, 1, 1)),
          {points}};
}

Kept scaledUniformly() {
  auto inner = std::make_shared<btBoxShape>(btVector3(s(0.2), s(0.16), s(0.12)));
  return {std::make_unique<btUniformScalingShape>(inner.get(), s(0.5)), {inner}};
}

Kept minkowskiSum() {
  auto box = std::make_shared<btBoxShape>(btVector3(s(0.08), s(0.06), s(0.04)));
  auto ball = std::make_shared<btSphereShape>(s(0.02));
  return {std::make_unique<btMinkowskiSumShape>(box.get(), ball.get()), {box, ball}};
}

Kept multiSphere() {
  const btVector3 centers[] = {{s(-0.05), 0, 0}, {s(0.05), 0, 0}};
  const btScalar radii[] = {s(0.06), s(0.05)};
  return {std::make_unique<btMultiSphereShape>(centers, radii, 2)};
}

Kept tetrahedron() {
  return {std::make_unique<btBU_Simplex1to4>(
      btVector3(s(-0.1), s(-0.1), s(-0.06)), btVector3(s(0.1), s(-0.1), s(-0.06)),
      btVector3(0, s(0.15), s(-0.06)), btVector3(0, 0, s(0.1)))};
}

Kept scaledBlock() {
  auto triangles = triangleMesh(block(), {0.5, 0.25, 2});
  auto inner = std::make_shared<btBvhTriangleMeshShape>(triangles.get(), true);
  return {std::make_unique<btScaledBvhTriangleMeshShape>(inner.get(), btVector3(2, 4, s(0.5))),
          {triangles, inner}};
}

Kept inside(Kept child) {
  auto compound = std::make_unique<btCompoundShape>();
  compound->addChildShape(at({0, 0, 0}), child.shape.get());
  child.data.emplace_back(std::move(child.shape));
  return {std::move(compound), std::move(child.data)};
}

// A row of the table, with a shape of it.
struct Row {
  const char* row;  // as the table says
  int type;
  std::function<Kept()> make;
  bool open = false;   // a sheet: it has no side
  bool round = false;  // a hull of 1,000 support points, which takes 40 ms a step
};

std::vector<Row> answered() {
  const btVector3 half(s(0.1), s(0.08), s(0.06));
  const auto solid = [](auto shape) { return Kept{std::move(shape)}; };
  return {
      {"`CloudShape`", CloudShape::kCloudType,
       [] {
         return Kept{std::make_unique<CloudShape>(fieldOf(boxMesh({0.2, 0.16, 0.12}), kVoxel))};
       }},
      {"box", BOX_SHAPE_PROXYTYPE, [=] { return solid(std::make_unique<btBoxShape>(half)); }},
      {"sphere", SPHERE_SHAPE_PROXYTYPE,
       [=] { return solid(std::make_unique<btSphereShape>(s(0.1))); }},
      {"capsule", CAPSULE_SHAPE_PROXYTYPE,
       [=] { return solid(std::make_unique<btCapsuleShape>(s(0.06), s(0.1))); }},
      {"cylinder", CYLINDER_SHAPE_PROXYTYPE,
       [=] {
         return solid(std::make_unique<btCylinderShapeZ>(btVector3(s(0.1), s(0.1), s(0.06))));
       }},
      {"cone", CONE_SHAPE_PROXYTYPE,
       [=] { return solid(std::make_unique<btConeShape>(s(0.1), s(0.15))); }},
      {"hull", CONVEX_HULL_SHAPE_PROXYTYPE, hull},
      {"plane", STATIC_PLANE_PROXYTYPE,
       [=] { return solid(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), 0)); }, true},
      {"other convex shapes", MULTI_SPHERE_SHAPE_PROXYTYPE, multiSphere, false, true},
      {"other convex shapes", CONVEX_TRIANGLEMESH_SHAPE_PROXYTYPE, convexTriangles},
      {"other convex shapes", CONVEX_POINT_CLOUD_SHAPE_PROXYTYPE, pointCloud},
      {"other convex shapes", TETRAHEDRAL_SHAPE_PROXYTYPE, tetrahedron},
      {"other convex shapes", UNIFORM_SCALING_SHAPE_PROXYTYPE, scaledUniformly},
      {"other convex shapes", MINKOWSKI_DIFFERENCE_SHAPE_PROXYTYPE, minkowskiSum, false, true},
      {"`btBvhTriangleMeshShape`", TRIANGLE_MESH_SHAPE_PROXYTYPE, [] { return bvhShape(block()); }},
      {"`btScaledBvhTriangleMeshShape`", SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE, scaledBlock},
      {"`btMultimaterialTriangleMeshShape`", MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE,
       [] { return multimaterialShape(block()); }},
      {"`btHeightfieldTerrainShape`", TERRAIN_SHAPE_PROXYTYPE,
       [] { return heightfieldShape(20, [](double, double) { return 0.0; }); }, true},
      {"`btGImpactMeshShape`", GIMPACT_SHAPE_PROXYTYPE, [] { return gimpactShape(block()); }},
      {"`btTriangleShape`", TRIANGLE_SHAPE_PROXYTYPE,
       [=] {
         return solid(std::make_unique<btTriangleShape>(btVector3(-1, -1, 0), btVector3(1, -1, 0),
                                                        btVector3(0, 1, 0)));
       },
       true},
      {"`btBox2dShape`", BOX_2D_SHAPE_PROXYTYPE,
       [=] { return solid(std::make_unique<btBox2dShape>(btVector3(1, 1, 0))); }, true},
      {"`btConvex2dShape`", CONVEX_2D_SHAPE_PROXYTYPE,
       [] {
         auto child = std::make_shared<btBox2dShape>(btVector3(1, 1, 0));
         return Kept{std::make_unique<btConvex2dShape>(child.get()), {child}};
       },
       true},
      {"`btCompoundShape`", COMPOUND_SHAPE_PROXYTYPE, [] { return inside(hull()); }},
      {"`btCompoundShape`", COMPOUND_SHAPE_PROXYTYPE, [] { return inside(bvhShape(block())); }},
  };
}

// Types of which clouds touch nothing, or that other tests show, with their rows.
const std::map<int, const char*> kOtherRows = {{EMPTY_SHAPE_PROXYTYPE, "`btEmptyShape`"},
                                               {SOFTBODY_SHAPE_PROXYTYPE, "`btSoftBody`"},
                                               {SDF_SHAPE_PROXYTYPE, "`btSdfCollisionShape`"}};

// Types of no class of Bullet 3.24, for own shapes or for nothing.
const std::set<int> kNoShapes = {CUSTOM_POLYHEDRAL_SHAPE_TYPE,
                                 IMPLICIT_CONVEX_SHAPES_START_HERE,
                                 CONVEX_SHAPE_PROXYTYPE,
                                 MINKOWSKI_SUM_SHAPE_PROXYTYPE,
                                 CUSTOM_CONVEX_SHAPE_TYPE,
                                 CONCAVE_SHAPES_START_HERE,
                                 CONCAVE_SHAPES_END_HERE,
                                 HFFLUID_SHAPE_PROXYTYPE,
                                 HFFLUID_BUOYANT_CONVEX_SHAPE_PROXYTYPE,
                                 INVALID_SHAPE_PROXYTYPE};

// The first cells of the table "Contacts".
std::string rowsOfTheTable() {
  std::ifstream in(CLOUDCONTACT_SOURCE_DIR "/docs/bullet.md");
  std::string line, rows;
  bool inside = false;
  while (std::getline(in, line)) {
    if (line.rfind("## ", 0) == 0) inside = line == "## Contacts";
    if (inside && line.rfind("| ", 0) == 0) rows += line.substr(0, line.find(" |", 2)) + '\n';
  }
  return rows;
}

TEST(ShapeTable, EachTypeOfBulletHasARow) {
  const std::string rows = rowsOfTheTable();
  std::map<int, std::string> known(kOtherRows.begin(), kOtherRows.end());
  for (const Row& row : answered()) {
    known[row.type] = row.row;
    EXPECT_EQ(row.make().shape->getShapeType(), row.type) << row.row;
  }
  for (int type = 0; type < MAX_BROADPHASE_COLLISION_TYPES; ++type) {
    const auto found = known.find(type);
    EXPECT_NE(found != known.end(), kNoShapes.count(type) > 0) << "type " << type;
    if (found != known.end()) {
      EXPECT_NE(rows.find(found->second), std::string::npos) << found->second;
    }
  }
}

double energyOf(const btRigidBody& body, const btVector3& down) {
  return 0.5 * body.getMass() * body.getLinearVelocity().length2() -
         kGravity * body.getMass() * body.getWorldTransform().getOrigin().dot(down);
}

double deepestOf(const BulletWorld& world) {
  double deepest = 0;
  for (const btManifoldPoint& p : world.points())
    deepest = std::max(deepest, -double(p.getDistance()));
  return deepest;
}

// Falls by a centimeter towards the shape's middle, along `down`, and turns neither itself nor
// aside, so that it cannot roll off.
void fall(const Row& row, const TestCloud& cloud, const btVector3& down) {
  SCOPED_TRACE(std::string(cloud.name) + " at " + row.row + ", type " + std::to_string(row.type));
  BulletWorld world;
  Kept kept = row.make();
  btVector3 low, high, own[2];
  kept.shape->getAabb(at({0, 0, 0}), low, high);
  world.add(std::move(kept.shape), 0, at({0, 0, 0}));
  CloudShape(cloud.field).getAabb(at({0, 0, 0}), own[0], own[1]);
  btVector3 place(0, 0, 0);
  for (int axis = 0; axis < 3; ++axis) {
    const double side = row.open && axis == 2 ? 0 : down[axis] < 0 ? high[axis] : low[axis];
    if (down[axis] != 0)
      place[axis] = s(side - down[axis] * (0.01 + (down[axis] < 0 ? -own[0][axis] : own[1][axis])));
  }
  btRigidBody& body = world.addCloud(cloud.field, 0.5, at(place));
  body.setGravity(s(kGravity) * down);
  body.setAngularFactor(0);
  body.setLinearFactor(down.absolute());
  const double start = energyOf(body, down);
  double most = start, deepest = 0;
  for (int i = 0; i < (row.round ? kSteps / 2 : kSteps); ++i) {
    world.step(1.0 / 240);
    most = std::max(most, energyOf(body, down));
    deepest = std::max(deepest, deepestOf(world));
  }
  EXPECT_LE(most, start + 1e-3 * 0.5 * kGravity * 0.01);
  EXPECT_LT(deepest, kVoxel);
  EXPECT_FALSE(world.points().empty());
  EXPECT_LT(body.getLinearVelocity().length(), 0.01);
  EXPECT_EQ(world.clouds.statistics().failures, 0u) << world.clouds.statistics().lastFailure;
  EXPECT_TRUE(diagnose(world.world).empty());
}

// By name: every run of the program makes the parameters, and the clouds themselves take 0.2 s.
class ShapeTable : public ::testing::TestWithParam<const char*> {};

TEST_P(ShapeTable, HoldsWhatFallsOnUnderAndBesideIt) {
  const TestCloud& cloud = testCloudOf(GetParam());
  for (const Row& row : answered()) {
    if (row.round && GetParam() != std::string("box")) continue;
    fall(row, cloud, {0, 0, -1});
    if (row.round) continue;
    if (row.type != STATIC_PLANE_PROXYTYPE) fall(row, cloud, {0, 0, 1});
    if (row.open) continue;
    fall(row, cloud, {-1, 0, 0});
    fall(row, cloud, {0, 1, 0});
  }
}

INSTANTIATE_TEST_SUITE_P(Clouds, ShapeTable, ::testing::Values("box", "torus", "cup"),
                         [](const auto& made) { return std::string(made.param); });

}  // namespace
}  // namespace cloudcontact::testing::shape_table_test
