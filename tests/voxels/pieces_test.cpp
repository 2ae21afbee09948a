// Cut clouds, their connected parts and their sums, against a flood fill over all voxels and closed
// forms.
#include <cloudcontact/voxels/matter_sums.h>
#include <cloudcontact/voxels/pieces.h>
#include <gtest/gtest.h>

#include <map>
#include <stdexcept>

#include "workpiece/cut_cases.h"

namespace cloudcontact::testing::pieces_test {
namespace {

template <typename Visit>
void forEachVoxel(const Cloud& cloud, Visit&& visit) {
  const Eigen::Vector3i n = cloud.size();
  for (int z = 0; z < n.z(); ++z)
    for (int y = 0; y < n.y(); ++y)
      for (int x = 0; x < n.x(); ++x) visit(x, y, z);
}

Inside boxFrom(const Vec3& low, const Vec3& high) {
  return [=](const Vec3& p) {
    return (p.array() >= low.array()).all() && (p.array() < high.array()).all();
  };
}
Inside either(const Inside& a, const Inside& b) {
  return [=](const Vec3& p) { return a(p) || b(p); };
}

// The part of each voxel by a flood fill without bricks, numbered in the order of discovery.
std::vector<int> flooded(const Cloud& cloud, int& parts) {
  const Eigen::Vector3i n = cloud.size();
  const auto index = [&](int x, int y, int z) { return x + n.x() * (y + n.y() * z); };
  std::vector<int> part(static_cast<std::size_t>(n.prod()), -1);
  parts = 0;
  forEachVoxel(cloud, [&](int x, int y, int z) {
    if (!cloud.coverage(x, y, z) || part[index(x, y, z)] >= 0) return;
    std::vector<Eigen::Vector3i> open{{x, y, z}};
    part[index(x, y, z)] = parts;
    while (!open.empty()) {
      const Eigen::Vector3i v = open.back();
      open.pop_back();
      for (int k = 0; k < 6; ++k) {
        const Eigen::Vector3i w = v + (k % 2 ? 1 : -1) * Eigen::Vector3i::Unit(k / 2);
        if (!cloud.coverage(w.x(), w.y(), w.z())) continue;
        int& p = part[index(w.x(), w.y(), w.z())];
        if (p >= 0) continue;
        p = parts;
        open.push_back(w);
      }
    }
    ++parts;
  });
  return part;
}

// Every voxel is in one part with all its coverage, together with the same voxels as in the flood
// fill.
void expectParts(const Cloud& cloud, const std::string& what) {
  int wanted = 0;
  const std::vector<int> truth = flooded(cloud, wanted);
  const std::vector<Cloud> found = pieces(cloud);
  ASSERT_EQ(static_cast<int>(found.size()), wanted) << what;
  std::map<int, int> numberOf;  // number in the flood fill -> part
  std::size_t v = 0;
  forEachVoxel(cloud, [&](int x, int y, int z) {
    int sum = 0, owner = -1;
    for (int p = 0; p < wanted; ++p)
      if (const int c = found[p].coverage(x, y, z)) {
        sum += c;
        owner = p;
      }
    ASSERT_EQ(sum, cloud.coverage(x, y, z)) << what;
    if (owner >= 0) {
      ASSERT_EQ(numberOf.try_emplace(truth[v], owner).first->second, owner) << what;
    }
    ++v;
  });
  EXPECT_EQ(static_cast<int>(numberOf.size()), wanted) << what;
}

TEST(Pieces, AreConnectedByFacesOnly) {
  const Cloud face =
      cloudOf(either(boxFrom({2, 2, 2}, {8, 8, 8}), boxFrom({8, 6, 6}, {14, 14, 14})), {2, 2, 2});
  EXPECT_EQ(pieces(face).size(), 1u);
  const Cloud edge =
      cloudOf(either(boxFrom({2, 2, 2}, {8, 8, 8}), boxFrom({8, 8, 2}, {14, 14, 8})), {2, 2, 2});
  EXPECT_EQ(pieces(edge).size(), 2u);
  const Cloud corner =
      cloudOf(either(boxFrom({2, 2, 2}, {8, 8, 8}), boxFrom({8, 8, 8}, {14, 14, 14})), {2, 2, 2});
  EXPECT_EQ(pieces(corner).size(), 2u);
  EXPECT_EQ(pieces(face)[0].voxels().table, face.voxels().table);
}

TEST(Pieces, AreThoseOfAFloodOverAllVoxels) {
  Random random(7);
  const Cloud whole = cloudOf(tooth({20, 20, 22}), {5, 5, 5});
  expectParts(whole, "whole");
  expectParts(cutCloud(whole, sawn(whole, 15.3, 17.6)), "sawn");
  Cloud dust = cloudOf(boxFrom({0, 0, 0}, {16, 16, 16}), {2, 2, 2});
  std::vector<VoxelCut> cuts = specks(dust, random, 6000);
  for (VoxelCut& c : cuts) c.coverage = c.coverage > 150 ? 1 : 0;
  dust = cutCloud(dust, cuts);
  expectParts(dust, "dust");
}

TEST(Pieces, ComeInTheOrderOfTheirFirstVoxels) {
  const Cloud cloud =
      cloudOf(either(boxFrom({18, 1, 1}, {22, 4, 4}), boxFrom({1, 1, 12}, {4, 4, 15})), {3, 1, 2});
  const std::vector<Cloud> parts = pieces(cloud);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].coverage(20, 2, 2), 255);
  EXPECT_EQ(parts[1].coverage(2, 2, 13), 255);
  EXPECT_EQ(parts[1].origin(), cloud.origin());
}

// The left half of one material, the right of another, sawn along the border.
Cloud twoMaterials() {
  const Cloud plain = cloudOf(boxFrom({2, 2, 2}, {30, 14, 14}), {4, 2, 2});
  auto voxels = std::make_shared<Cloud::Voxels>(plain.voxels());
  voxels->materials = {"light", "heavy"};
  for (std::size_t t = 0; t < voxels->table.size(); ++t)
    voxels->materialTable.push_back(t % 4 < 2 ? -1 : -2);
  voxels->materialTable[1] = 0;  // a brick of both
  voxels->material.emplace_back().fill(0);
  voxels->material[0][7 + 8 * 7 + 64 * 7] = 1;
  return Cloud(plain.voxelSize(), plain.origin(), voxels);
}

TEST(Pieces, KeepTheirMaterials) {
  const Cloud cloud = twoMaterials();
  const Cloud cut = cutCloud(cloud, sawn(cloud, 17, 19));
  const std::vector<Cloud> parts = pieces(cut);
  ASSERT_EQ(parts.size(), 2u);
  for (const Cloud& part : parts) {
    EXPECT_EQ(part.materials(), cloud.materials());
    forEachVoxel(part, [&](int x, int y, int z) {
      if (part.coverage(x, y, z)) {
        ASSERT_EQ(part.material(x, y, z), cloud.material(x, y, z));
      }
    });
  }
  EXPECT_EQ(parts[0].material(15, 7, 7), 1);
}

TEST(Pieces, OfNothing) {
  EXPECT_TRUE(pieces(Cloud()).empty());
  const Cloud cloud = cloudOf(ball({8, 8, 8}, 4), {2, 2, 2});
  EXPECT_TRUE(pieces(cutCloud(cloud, bite(cloud, {8, 8, 8}, 6))).empty());
}

TEST(CutCloud, OnlyRemoves) {
  const Cloud cloud = cloudOf(ball({8, 8, 8}, 5), {2, 2, 2});
  const std::vector<VoxelCut> cuts = {
      {{8, 8, 8}, 100}, {{8, 8, 8}, 200}, {{0, 0, 0}, 77}, {{9, 8, 8}, 255}};
  const Cloud cut = cutCloud(cloud, cuts);
  forEachVoxel(cloud, [&](int x, int y, int z) {
    const bool middle = x == 8 && y == 8 && z == 8;
    ASSERT_EQ(cut.coverage(x, y, z), middle ? 100 : cloud.coverage(x, y, z));
  });
  EXPECT_EQ(cloud.coverage(8, 8, 8), 255) << "the cloud itself must not change";
}

bool equalClouds(const Cloud& a, const Cloud& b) {
  bool equal = a.bricks() == b.bricks();
  forEachVoxel(
      a, [&](int x, int y, int z) { equal = equal && a.coverage(x, y, z) == b.coverage(x, y, z); });
  return equal;
}

// Pieces found from the cut alone are those of a search of everything: bites that leave one part,
// saws that sever it, specks that leave crumbs.
TEST(Pieces, FoundNearACutAreAllPieces) {
  Random random(11);
  int severed = 0, whole = 0;
  for (int k = 0; k < 40; ++k) {
    const Cloud cloud = cloudOf(tooth({20, 20, 22}), {5, 5, 5});
    ASSERT_EQ(pieces(cloud).size(), 1u);
    const Vec3 at = Vec3(20, 20, 22) + 12 * (random.inCube() - Vec3::Constant(0.5));
    const Cloud after =
        cutCloud(cloud, k % 4 == 0   ? sawn(cloud, at.x(), at.x() + random.uniform(0.2, 2))
                        : k % 4 == 1 ? specks(cloud, random, 4000)
                        : k % 4 == 2 ? bite(cloud, at, random.uniform(7, 14))
                                     : bite(cloud, at, random.uniform(1, 6)));
    const std::vector<Cloud> found = pieces(after, cloud), all = pieces(after);
    ASSERT_EQ(found.size(), all.size()) << k;
    for (std::size_t i = 0; i < all.size(); ++i) EXPECT_TRUE(equalClouds(found[i], all[i])) << k;
    (all.size() > 1 ? severed : whole) += 1;
  }
  EXPECT_GE(severed, 5);
  EXPECT_GE(whole, 5);
}

// A ring that is cut once is one piece, though the cut's two sides are connected far from it only;
// cut twice, it is two.
TEST(Pieces, OfARing) {
  const Cloud ring = cloudOf(
      [](const Vec3& p) {
        const double r = std::hypot(p.x() - 16, p.y() - 16);
        return r > 9 && r < 13 && std::abs(p.z() - 4) < 2;
      },
      {4, 4, 1});
  const Cloud once = cutCloud(ring, bite(ring, Vec3(27, 16, 4), 5));
  EXPECT_EQ(pieces(once, ring).size(), 1u);
  const Cloud twice = cutCloud(once, bite(once, Vec3(5, 16, 4), 5));
  EXPECT_EQ(pieces(twice, once).size(), 2u);
}

TEST(CutCloud, RefusesVoxelsOutsideTheGrid) {
  const Cloud cloud = cloudOf(ball({8, 8, 8}, 5), {2, 2, 2});
  for (const Eigen::Vector3i& v :
       {Eigen::Vector3i(-1, 3, 3), Eigen::Vector3i(3, 16, 3), Eigen::Vector3i(3, 3, 1 << 30)}) {
    const VoxelCut one{v, 0};
    EXPECT_THROW(cutCloud(cloud, {&one, 1}), std::out_of_range);
    EXPECT_THROW(cutCloud(Cloud(), {&one, 1}), std::invalid_argument);
  }
}

TEST(Matter, OfABoxOfTwoDensities) {
  const Cloud cloud = cloudOf(boxFrom({2, 2, 2}, {30, 14, 14}), {4, 2, 2}, 0.5);
  const std::vector<MatterSums> sums = matterSums(cloud);
  const MassProperties box = massPropertiesOf(sums, cloud, {3});
  const Vec3 edges = 0.5 * Vec3(28, 12, 12);
  const double mass = 3 * edges.prod();
  EXPECT_NEAR(box.mass, mass, 1e-12 * mass);
  EXPECT_LT((box.centerOfMass - cloud.origin() - 0.5 * Vec3(16, 8, 8)).norm(), 1e-12);
  const Vec3 squares = edges.cwiseAbs2();
  const Vec3 truth =
      mass / 12 *
      Vec3(squares.y() + squares.z(), squares.z() + squares.x(), squares.x() + squares.y());
  EXPECT_LT((box.inertia - Eigen::Matrix3d(truth.asDiagonal())).norm(), 1e-11 * truth.norm());
  // Light up to x = 16, heavy beyond, except for one voxel.
  const Cloud two = twoMaterials();
  const MassProperties both = massPropertiesOf(matterSums(two), two, {1000, 3000});
  const double voxel = 1e-9, light = 14 * 144 * 1000 * voxel, heavy = 14 * 144 * 3000 * voxel;
  EXPECT_NEAR(both.mass, light + heavy + 2000 * voxel, 1e-9 * heavy);
  EXPECT_NEAR(both.centerOfMass.x() - two.origin().x(),
              (9 * light + 23 * heavy) / (light + heavy) * 1e-3, 2e-6);
}

TEST(Matter, OfPartsAddsUpExactly) {
  const Cloud cloud = cloudOf(tooth({20, 20, 22}), {5, 5, 5});
  const Cloud cut = cutCloud(cloud, sawn(cloud, 18.2, 21.7));
  const MatterSums whole = matterSums(cut)[0];
  MatterSums sum;
  for (const Cloud& part : pieces(cut)) sum += matterSums(part)[0];
  EXPECT_TRUE(sum == whole);
  sum -= whole;
  EXPECT_TRUE(sum == MatterSums{});
}

TEST(Matter, FromWhatACutChangedIsExact) {
  Random random(5);
  for (Cloud cloud : {cloudOf(tooth({20, 20, 22}), {5, 5, 5}), twoMaterials()}) {
    std::vector<MatterSums> known = matterSums(cloud);
    for (int k = 0; k < 4; ++k) {
      const Vec3 at = random.inCube().cwiseProduct(cloud.size().cast<double>());
      const Cloud after = cutCloud(cloud, bite(cloud, at, random.uniform(2, 7)));
      known = matterSums(after, cloud, known);
      EXPECT_TRUE(known == matterSums(after)) << k;
      cloud = after;
    }
  }
}

TEST(Matter, RefusesBadDensities) {
  const Cloud cloud = twoMaterials();
  const std::vector<MatterSums> sums = matterSums(cloud);
  for (const std::vector<double>& bad :
       {std::vector<double>{}, {1, 2, 3}, {1, 0}, {-1}, {NAN}, {1, INFINITY}})
    EXPECT_THROW(massPropertiesOf(sums, cloud, bad), std::invalid_argument);
}

}  // namespace
}  // namespace cloudcontact::testing::pieces_test
