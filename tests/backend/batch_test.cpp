// A batch gives what ContactFinder gives for each pair, to the bit, on the CPU and through OpenCL.
#include <cloudcontact/batch.h>
#include <cloudcontact/digitize.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "contact_cases.h"

namespace cloudcontact::testing {
namespace {

// A ring with a wound tube, or a rod with a thread: a grid of points over (u, v), closed both ways.
template <typename Place>
Mesh wound(int along, int around, Place place) {
  Mesh mesh;
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < around; ++j)
      mesh.vertices.push_back(
          place(2 * std::numbers::pi * i / along, 2 * std::numbers::pi * j / around));
  const auto at = [&](int i, int j) { return i % along * around + j % around; };
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < around; ++j) {
      mesh.triangles.emplace_back(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      mesh.triangles.emplace_back(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  return mesh;
}

Mesh torusMesh(double ring, double tube) {
  return wound(96, 48, [=](double u, double v) {
    const double r = ring + tube * std::cos(v);
    return Vec3(r * std::cos(u), r * std::sin(u), tube * std::sin(v));
  });
}

std::uint64_t bits(double v) {
  std::uint64_t b = 0;
  std::memcpy(&b, &v, sizeof v);
  return b;
}

void same(double a, double b, const char* what) {
  EXPECT_EQ(bits(a), bits(b)) << what << ": " << a << " and " << b;
}
void same(const Vec3& a, const Vec3& b, const char* what) {
  for (int i = 0; i < 3; ++i) same(a[i], b[i], what);
}

void expectSame(const ContactResult& got, const ContactResult& want) {
  EXPECT_EQ(got.samples, want.samples);
  ASSERT_EQ(got.patches.size(), want.patches.size());
  ASSERT_EQ(got.points.size(), want.points.size());
  for (std::size_t i = 0; i < got.patches.size(); ++i) {
    const Patch &p = got.patches[i], &q = want.patches[i];
    same(p.position, q.position, "patch position");
    same(p.normal, q.normal, "patch normal");
    same(p.depth, q.depth, "patch depth");
    same(p.area, q.area, "area");
    same(p.confidence, q.confidence, "confidence");
    EXPECT_EQ(p.doubt, q.doubt);
  }
  for (std::size_t i = 0; i < got.points.size(); ++i) {
    const ContactPoint &p = got.points[i], &q = want.points[i];
    same(p.position, q.position, "position");
    same(p.normal, q.normal, "normal");
    same(p.depth, q.depth, "depth");
    same(p.stiffness, q.stiffness, "stiffness");
    same(p.damping, q.damping, "damping");
    EXPECT_EQ(p.id, q.id);
  }
}

// Bodies of many forms, and pairs of them in random poses: apart, grazing, deep.
struct Pairs {
  BodyMaker maker{5e-4, Random(11)};
  std::vector<Body> bodies;
  std::vector<double> sizes;
  std::vector<BatchPair> pairs;

  void add(Body body, double size) {
    bodies.push_back(std::move(body));
    sizes.push_back(size);
  }

  Pairs() {
    const double v = maker.voxel;
    add(maker.sphere(12), 12 * v);
    add(maker.box(Vec3(20, 14, 9)), 10 * v);
    add(maker.box(Vec3(16, 16, 16), true), 10 * v);
    add(maker.cylinder(8, 22), 10 * v);
    add(maker.cloud(torusMesh(14 * v, 6 * v)), 14 * v);
    for (int k = 0; k < 60; ++k) {
      const std::size_t i = std::size_t(k) % bodies.size(), j = std::size_t(k) / 5 % bodies.size();
      Pose pose;
      pose.orientation = maker.random.rotation();
      const double far = (sizes[i] + sizes[j]) * maker.random.uniform(0.2, 1.1);
      pose.position = far * (maker.random.rotation() * Vec3::UnitX());
      BatchPair pair{bodies[i].at({}), bodies[j].at(pose), {}};
      if (k % 4 == 1) pair.settings.samples = 3000;
      if (k % 7 == 2) pair.settings.law = LawForm::Foundation;
      if (k % 9 == 4) pair.settings.margin = 1.5 * v;
      pairs.push_back(pair);
    }
  }
};

const Pairs& all() {
  static const Pairs pairs;
  return pairs;
}

void equalToFinder(ContactBatch& batch, int times) {
  const std::vector<BatchPair>& pairs = all().pairs;
  std::vector<ContactFinder> finders(pairs.size());
  std::size_t touching = 0;
  for (int time = 0; time < times; ++time) {
    const auto results = batch.find(pairs);
    ASSERT_EQ(results.size(), pairs.size());
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      SCOPED_TRACE("pair " + std::to_string(k));
      const ContactResult& want = finders[k].find(pairs[k].a, pairs[k].b, pairs[k].settings);
      expectSame(*results[k], want);
      touching += !want.patches.empty();
    }
  }
  EXPECT_GT(touching, pairs.size() / 3);
}

TEST(Batch, OnTheCpuEqualsTheFinder) {
  ContactBatch batch({Backend::Cpu, 2});
  EXPECT_EQ(batch.backend(), Backend::Cpu);
  equalToFinder(batch, 2);
}

TEST(Batch, OnTheDeviceEqualsTheFinder) {
  ContactBatch batch({Backend::OpenCl, 2});
  // No device at all is no fault; one that is refused is.
  if (batch.message().find("no OpenCL device; install") != std::string::npos)
    GTEST_SKIP() << batch.message();
  ASSERT_EQ(batch.backend(), Backend::OpenCl) << batch.message();
  equalToFinder(batch, 3);
  EXPECT_GT(batch.report().onDevice, all().pairs.size() / 2);
}

}  // namespace
}  // namespace cloudcontact::testing
