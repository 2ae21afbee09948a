// Compares two contacts to the bit.
#pragma once

#include <cloudcontact/contact/contact.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>

namespace cloudcontact::testing {

inline std::uint64_t bits(double v) {
  std::uint64_t b = 0;
  std::memcpy(&b, &v, sizeof v);
  return b;
}

inline void same(double a, double b, const char* what) {
  EXPECT_EQ(bits(a), bits(b)) << what << ": " << a << " and " << b;
}
inline void same(const Vec3& a, const Vec3& b, const char* what) {
  for (int i = 0; i < 3; ++i) same(a[i], b[i], what);
}

// IDs of points persist between queries, so finders with different histories assign different ones.
enum class Ids { Compared, Ignored };

inline void expectSame(const ContactResult& got, const ContactResult& want,
                       Ids ids = Ids::Compared) {
  EXPECT_EQ(got.samples, want.samples);
  EXPECT_EQ(got.level, want.level);
  same(got.depthError, want.depthError, "error of the depth");
  same(got.pointed, want.pointed, "b of the pair");
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
    same(p.slope, q.slope, "slope");
    same(p.damping, q.damping, "damping");
    if (ids == Ids::Compared) {
      EXPECT_EQ(p.id, q.id);
    }
  }
}

}  // namespace cloudcontact::testing
