// Bodies that touch with few samples and are near with many: a search finds what all samples find.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "contact/contact_cases.h"
#include "contact/hit_search.h"
#include "contact/level_search.h"
#include "field/mesh_field.h"
#include "mesh/thread_meshes.h"

namespace cloudcontact::testing::light_contact_test {
namespace {

// The volume between the surfaces that hits tell of [m^3].
double volumeOf(const HitColumns& hits) {
  double sum = 0;
  for (std::size_t i = 0; i < hits.size(); ++i)
    sum += static_cast<double>(hits[i].area) * static_cast<double>(hits[i].depth1);
  return sum;
}

// Adds the hits of all samples of one body.
void askAll(const ContactBody& own, const ContactBody& other, const PairFrame& frame, Side side,
            HitColumns& hits) {
  const FieldData& samples = own.field->data();
  const search::Direction dir{wayOf(own, other, frame),
                              samples,
                              samples.samples(),
                              0,
                              side,
                              static_cast<float>(samples.cloud().voxelSize())};
  search::Candidates candidates;
  candidates.all = false;
  candidates.runs = {{0, static_cast<std::uint32_t>(samples.samples().levels[0].samples.size())}};
  search::Shares shares;
  search::searchField(dir, other.field->data(), candidates, hits, shares);
}

// A thread by ISO 68: flats of an eighth of the pitch at the crests, of a quarter at the roots.
double threadAt(double radius, double pitch, double angle, double z) {
  const double turn = z / pitch - angle / (2 * std::numbers::pi);
  const double rise = 2 * std::abs(turn - std::floor(turn) - 0.5);
  return radius - 0.54 * pitch * std::clamp((rise - 0.125) / 0.625, 0.0, 1.0);
}

Vec3 around(double r, double angle, double z) {
  return {r * std::cos(angle), r * std::sin(angle), z};
}

// A rod and a ring with the same thread, five voxels a pitch, and some play: tilted and shifted
// until they touch here and there.
TEST(LightContact, NothingThatPressesIsLeftOut) {
  constexpr double kVoxel = 0.4e-3, kPitch = 5 * kVoxel, kRadius = 20 * kVoxel;
  const auto rod = fieldOf(revolvedMesh(180, 480, false,
                                        [&](double angle, double s) {
                                          const double z = 50 * kVoxel * (s - 0.5);
                                          const bool end = s == 0 || s == 1;
                                          const double r = threadAt(kRadius, kPitch, angle, z);
                                          return around(end ? 0 : r, angle, z);
                                        }),
                           kVoxel);
  const auto ring =
      fieldOf(revolvedMesh(180, 480, true,
                           [&](double angle, double s) {
                             const double z = 30 * kVoxel * (std::min(2 * s, 2 - 2 * s) - 0.5);
                             const double r = threadAt(kRadius, kPitch, angle, z) + 0.7 * kVoxel;
                             return around(s < 0.5 ? r : 30 * kVoxel, angle, z);
                           }),
              kVoxel);
  Random random(3);
  double found = 0, all = 0;
  int light = 0;
  for (int i = 0; i < 100; ++i) {
    Pose pose;
    pose.position = 0.3 * kVoxel * (2 * random.inCube() - Vec3::Ones());
    pose.orientation = Eigen::AngleAxisd(0.01 * random.uniform(),
                                         (random.inCube() - 0.5 * Vec3::Ones()).normalized());
    ContactBody a, b;
    a.field = rod.get();
    b.field = ring.get();
    b.pose = pose;
    const PairFrame frame = frameOf(a, b);
    HitSearch search;
    HitColumns hits, every;
    search.run(a, b, frame, 0, HitSearch::kAll, hits);
    askAll(a, b, frame, kA, every);
    askAll(b, a, frame, kB, every);
    if (every.empty() || every.size() > 3000) continue;
    ++light;
    found += volumeOf(hits);
    all += volumeOf(every);
  }
  EXPECT_GE(light, 50);
  EXPECT_LE(found, all);
  EXPECT_GE(found, 0.99 * all) << light << " poses";
}

}  // namespace
}  // namespace cloudcontact::testing::light_contact_test
