// Inspection and repair of meshes, against counts and volumes known by construction.
#include <cloudcontact/mesh/mesh_repair.h>

#include "mesh/test_meshes.h"

namespace cloudcontact::mesh_test {
namespace {

using namespace test;

TEST(MeshInspect, ClosedBodiesByClosedForms) {
  const MeshReport box = inspect(boxMesh({1, 2, 3}, {3, 5, 7}));
  EXPECT_TRUE(box.closed());
  EXPECT_EQ(box.degenerateTriangles, 0u);
  EXPECT_NEAR(box.volume, 24, 1e-12);
  EXPECT_NEAR(box.area, 2 * (6 + 8 + 12), 1e-12);
  const MeshReport tet =
      inspect(tetrahedronMesh({100, 0, 0}, {101, 0, 0}, {100, 1, 0}, {100, 0, 1}));
  EXPECT_NEAR(tet.volume, 1.0 / 6, 1e-12);
  EXPECT_NEAR(tet.area, 1.5 + std::sqrt(3) / 2, 1e-12);
}

TEST(MeshInspect, SoupIsWeldedFirst) {
  const MeshReport report = inspect(soup(sphereMesh(1, 3)));
  EXPECT_TRUE(report.closed());
  EXPECT_NEAR(report.volume, inspect(sphereMesh(1, 3)).volume, 1e-12);
}

TEST(MeshInspect, CountsFaults) {
  Mesh mesh = boxMesh({0, 0, 0}, {1, 1, 1});
  mesh.triangles.pop_back();
  EXPECT_EQ(inspect(mesh).openEdges, 3u);
  mesh.triangles.emplace_back(0, 0, 1);
  EXPECT_EQ(inspect(mesh).degenerateTriangles, 1u);
  mesh = boxMesh({0, 0, 0}, {1, 1, 1});
  mesh.triangles.push_back(mesh.triangles[0]);
  EXPECT_EQ(inspect(mesh).overusedEdges, 3u);
  EXPECT_EQ(inspect(mesh).openEdges, 0u);
  EXPECT_LT(inspect(turnedInsideOut(mesh)).volume, 0);
  EXPECT_EQ(inspect(sheetMesh(1, 4)).openEdges, 16u);
  EXPECT_EQ(inspect(Mesh()).area, 0);
}

// -0 and 0 are equal.
TEST(MeshInspect, SignedZerosWeld) {
  Mesh mesh = soup(boxMesh({0, 0, 0}, {1, 1, 1}));
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 2)
    for (int k = 0; k < 3; ++k)
      if (mesh.vertices[i][k] == 0) mesh.vertices[i][k] = -0.0;
  EXPECT_TRUE(inspect(mesh).closed());
}

TEST(MeshInspect, RefusesBadNumbers) {
  Mesh mesh = boxMesh({0, 0, 0}, {1, 1, 1});
  mesh.triangles[3][1] = 8;
  EXPECT_THROW(inspect(mesh), std::invalid_argument);
  EXPECT_THROW(mended(mesh), std::invalid_argument);
  EXPECT_THROW(isSheet(mesh), std::invalid_argument);
  EXPECT_THROW(shell(mesh, 0.1), std::invalid_argument);
  mesh = boxMesh({0, 0, 0}, {1, NAN, 1});
  EXPECT_THROW(inspect(mesh), std::invalid_argument);
}

TEST(MeshScaled, VolumeScalesByTheProductAlsoMirrored) {
  const Mesh box = boxMesh({0, 0, 0}, {1, 2, 3});
  EXPECT_NEAR(inspect(box.scaled({2, 3, 0.5})).volume, 6 * 3, 1e-12);
  EXPECT_NEAR(inspect(box.scaled({-1, 1, 1})).volume, 6, 1e-12);
  EXPECT_NEAR(inspect(box.scaled({-1, -1, 1})).volume, 6, 1e-12);
}

TEST(MeshMended, WeldsWithinTheTolerance) {
  Mesh mesh = soup(moved(sphereMesh(1, 3), oddTurn(), {0, 0, 0}));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> jitter(-1e-7, 1e-7);
  for (Vector3d& v : mesh.vertices) v += Vector3d(jitter(random), jitter(random), jitter(random));
  EXPECT_FALSE(inspect(mesh).closed());
  const Mesh whole = mended(mesh, 1e-6);
  EXPECT_TRUE(inspect(whole).closed());
  EXPECT_EQ(whole.vertices.size(), sphereMesh(1, 3).vertices.size());
  EXPECT_NEAR(inspect(whole).volume, inspect(sphereMesh(1, 3)).volume, 1e-5);
  // A tolerance larger than the body leaves nothing.
  EXPECT_TRUE(mended(mesh, 10).triangles.empty());
}

TEST(MeshMended, TrianglesFollowTheMajorityOfTheirComponent) {
  const Mesh sphere = sphereMesh(1, 3);
  Mesh mixed = sphere;
  std::mt19937 random(1);
  for (Vector3i& t : mixed.triangles)
    if (random() % 3 == 0) std::swap(t[1], t[2]);
  EXPECT_NEAR(inspect(mended(mixed)).volume, inspect(sphere).volume, 1e-12);
  EXPECT_NEAR(inspect(mended(turnedInsideOut(mixed))).volume, inspect(sphere).volume, 1e-12);
}

TEST(MeshMended, KeepsCavitiesAndReversesStrayBodies) {
  const Mesh outer = sphereMesh(1, 3), cavity = turnedInsideOut(sphereMesh(0.5, 3));
  const double hollow = inspect(outer).volume + inspect(cavity).volume;
  EXPECT_NEAR(inspect(mended(joined(outer, cavity))).volume, hollow, 1e-12);
  EXPECT_NEAR(inspect(mended(turnedInsideOut(joined(outer, cavity)))).volume, hollow, 1e-12);
  const Mesh stray = turnedInsideOut(moved(sphereMesh(0.5, 3), oddTurn(), {3, 0, 0}));
  EXPECT_NEAR(inspect(mended(joined(outer, stray))).volume,
              inspect(outer).volume - inspect(stray).volume, 1e-12);
  // A body in a cavity in a body is material again.
  const Mesh core = sphereMesh(0.2, 3);
  EXPECT_NEAR(inspect(mended(joined(joined(outer, cavity), core))).volume,
              hollow + inspect(core).volume, 1e-12);
}

TEST(MeshMended, DropsDoubles) {
  const Mesh box = boxMesh({0, 0, 0}, {1, 1, 1});
  EXPECT_EQ(mended(joined(box, box)).triangles.size(), 12u);
  EXPECT_NEAR(inspect(mended(joined(box, box))).volume, 1, 1e-12);
  // Made two-sided for display.
  EXPECT_EQ(mended(joined(box, turnedInsideOut(box))).triangles.size(), 12u);
  EXPECT_NEAR(inspect(mended(joined(box, turnedInsideOut(box)))).volume, 1, 1e-12);
  // Two bodies that share a face keep it.
  const Mesh pair = joined(box, moved(box, Eigen::Quaterniond::Identity(), {1, 0, 0}));
  EXPECT_EQ(mended(pair).triangles.size(), 24u);
  EXPECT_NEAR(inspect(mended(pair)).volume, 2, 1e-12);
}

TEST(MeshSheet, DistinguishesSheetsFromBodiesWithHoles) {
  const Mesh sphere = sphereMesh(1, 4), box = boxMesh({0, 0, 0}, {1, 1, 1});
  EXPECT_FALSE(isSheet(sphere));
  EXPECT_FALSE(isSheet(turnedInsideOut(sphere)));
  EXPECT_FALSE(isSheet(withHoles(sphere, 300, 2)));
  EXPECT_FALSE(isSheet(turnedInsideOut(withHoles(sphere, 300, 2))));
  Mesh lidless = box;
  lidless.triangles.resize(10);
  EXPECT_FALSE(isSheet(lidless));
  EXPECT_TRUE(isSheet(sheetMesh(1, 9)));
  Mesh terrain = sheetMesh(1, 20);
  for (Vector3d& v : terrain.vertices) v[2] = 0.05 * std::sin(9 * v[0]) * std::cos(7 * v[1]);
  EXPECT_TRUE(isSheet(terrain));
  EXPECT_TRUE(isSheet(turnedInsideOut(terrain)));
  EXPECT_TRUE(isSheet(soup(terrain)));
  EXPECT_FALSE(isSheet(Mesh()));
  for (const Mesh& mesh : {sphere, lidless, sheetMesh(1, 9), terrain, Mesh()}) {
    bool sheet = !isSheet(mesh);
    mended(mesh, 0, &sheet);
    EXPECT_EQ(sheet, isSheet(mesh));
  }
}

TEST(MeshShell, FlatSheetBecomesAPlateBehindIt) {
  for (const double t : {0.01, 0.3}) {
    const Mesh plate = shell(sheetMesh(2, 5), t);
    const MeshReport report = inspect(plate);
    EXPECT_TRUE(report.closed());
    EXPECT_NEAR(report.volume, 4 * t, 1e-12);
    EXPECT_NEAR(report.area, 8 + 8 * t, 1e-12);
    for (const Vector3d& v : plate.vertices) {
      EXPECT_LE(v[2], 0);
      EXPECT_GE(v[2], -t - 1e-12);
    }
  }
}

// A roof: the faces move by the thickness, so the vertices on the ridge move farther.
TEST(MeshShell, KeepsItsThicknessAtARidge) {
  Mesh roof;
  for (int y = 0; y < 2; ++y)
    for (int x = -1; x < 2; ++x) roof.vertices.emplace_back(x, 5.0 * y, -0.5 * std::abs(x));
  roof.triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
  const Mesh thick = shell(roof, 0.1);
  EXPECT_TRUE(inspect(thick).closed());
  // Behind the ridge the inner edge lies 0.1 / cos(slope) below.
  const double below = 0.1 * std::sqrt(1.25);
  double found = -1;
  for (const Vector3d& v : thick.vertices)
    if (std::abs(v[0]) < 1e-9 && v[1] < 0.1 && v[2] < 0) found = -v[2];
  EXPECT_NEAR(found, below, 1e-9);
}

TEST(MeshShell, SphereShellByItsVolume) {
  // Half a sphere, whose inside is behind its faces.
  Mesh dome = sphereMesh(1, 5);
  std::erase_if(dome.triangles, [&](const Vector3i& t) {
    return (dome.vertices[t[0]] + dome.vertices[t[1]] + dome.vertices[t[2]])[2] < 0;
  });
  const Mesh thick = shell(dome, 0.05);
  EXPECT_TRUE(inspect(thick).closed());
  EXPECT_NEAR(inspect(thick).volume, 2 * std::numbers::pi / 3 * (1 - std::pow(0.95, 3)), 2e-3);
}

TEST(MeshShell, RefusesBadThickness) {
  for (const double t : {0.0, -1.0, std::nan(""), double(INFINITY)})
    EXPECT_THROW(shell(sheetMesh(1, 2), t), std::invalid_argument) << t;
}

}  // namespace
}  // namespace cloudcontact::mesh_test
