// Bodies that touch with few samples and are near with many: a search finds what all samples find.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "contact/contact_cases.h"
#include "contact/hit_search.h"
#include "contact/level_search.h"
#include "contact/pressed_parts.h"
#include "field/mesh_field.h"
#include "mesh/thread_meshes.h"

namespace cloudcontact::testing::light_contact_test {
namespace {

// The volume between the surfaces that hits tell of [m^3], of those that face the other body by
// `facing` at least.
double volumeOf(const HitColumns& hits, float facing = -1) {
  double sum = 0;
  for (std::size_t i = 0; i < hits.size(); ++i)
    if (hits[i].facing >= facing)
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
  if (other.shape)
    search::searchShape(dir, *other.shape, toShapeOf(own, other), candidates, hits, shares);
  else
    search::searchField(dir, other.field->data(), candidates, hits, shares);
}

// What searches find from few samples to many, and what all samples do.
struct Found {
  double volume = 0, ofAll = 0;  // [m^3]
  std::size_t hits = 0;

  void add(const ContactBody& a, const ContactBody& b, float facing = -1) {
    const PairFrame frame = frameOf(a, b);
    HitSearch search;
    HitColumns some, every;
    search.run(a, b, frame, 0, HitSearch::kAll, some);
    if (a.field) askAll(a, b, frame, kA, every);
    if (b.field) askAll(b, a, frame, kB, every);
    volume += volumeOf(some, facing);
    ofAll += volumeOf(every, facing);
    hits += some.size();
  }
};

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
  EXPECT_GE(found, 0.996 * all) << light << " poses";
}

// Parts with and without edges, which touch by a tenth of a voxel to one.
TEST(LightContact, PartsPressedTogetherLoseNothing) {
  for (const char* kind : {"pegs", "boxes", "corners"}) {
    Found found;
    for (const PressedPair& pair : pressedPairs(kind))
      found.add(pair.a->at(pair.poseA), pair.b->at(pair.poseB));
    EXPECT_GT(found.hits, 100u) << kind;
    EXPECT_LE(found.volume, found.ofAll * (1 + 1e-9)) << kind;
    EXPECT_GE(found.volume, 0.999 * found.ofAll) << kind;
  }
}

// A field that can be renewed has no bends: searches in it ask more samples, and find no more.
TEST(LightContact, BendsSpareSamplesAndLoseNoHit) {
  std::size_t asked[2] = {0, 0};
  for (const char* kind : {"boxes", "corners"})
    for (const PressedPair& pair : pressedPairs(kind)) {
      FieldSettings settings;
      settings.renewable = true;
      settings.threads = 1;
      const auto a = SurfaceField::build(pair.a->field->cloud(), settings),
                 b = SurfaceField::build(pair.b->field->cloud(), settings);
      ContactBody ownA = pair.a->at(pair.poseA), ownB = pair.b->at(pair.poseB);
      HitColumns hits[2];
      for (int renewable = 0; renewable < 2; ++renewable) {
        HitSearch search;
        search.run(ownA, ownB, frameOf(ownA, ownB), 0, ContactSettings::kSamples, hits[renewable]);
        asked[renewable] += search.lookups();
        ownA.field = a.get(), ownB.field = b.get();
      }
      EXPECT_EQ(hits[0].size(), hits[1].size()) << pair.name;
      EXPECT_EQ(volumeOf(hits[0]), volumeOf(hits[1])) << pair.name;
    }
  EXPECT_LT(double(asked[0]), 0.63 * double(asked[1]));
}

// A half-space rises above its plane nowhere, so of what faces it a search leaves out nothing.
TEST(LightContact, OnAPlaneEveryHitIsFound) {
  constexpr double kVoxel = 1e-3;
  constexpr float kFaces = 0.5f;
  const auto torus = fieldOf(revolvedMesh(90, 60, true,
                                          [&](double angle, double s) {
                                            const double turn = 2 * std::numbers::pi * s;
                                            return around(kVoxel * (20 + 5 * std::cos(turn)), angle,
                                                          5 * kVoxel * std::sin(turn));
                                          }),
                             kVoxel);
  const Solid plane = HalfSpace{};
  Random random(5);
  Found found;
  for (int i = 0; i < 100; ++i) {
    ContactBody a, b;
    a.field = torus.get();
    a.pose.orientation = random.rotation();
    b.shape = &plane;
    // From afar, in steps of a third of a voxel until some samples touch.
    HitColumns hits;
    for (double far = 30 * kVoxel; hits.empty() && far > 0; far -= 0.33 * kVoxel) {
      a.pose.position.z() = far;
      hits.clear();
      askAll(a, b, frameOf(a, b), kA, hits);
    }
    found.add(a, b, kFaces);
  }
  EXPECT_GT(found.hits, 1000u);
  EXPECT_EQ(found.volume, found.ofAll);
}

}  // namespace
}  // namespace cloudcontact::testing::light_contact_test
