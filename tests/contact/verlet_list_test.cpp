// A finder whose pair hardly moves looks up only the samples of its Verlet lists, and finds the
// same bits as a finder without lists.
#include <gtest/gtest.h>

#include "contact/contact_cases.h"
#include "contact/pair_frame.h"
#include "contact/same_contact.h"
#include "contact/verlet_lists.h"
#include "voxels/small_clouds.h"

namespace cloudcontact::testing::verlet_list_test {
namespace {

constexpr double kVoxel = 1e-3;

// A pair of clouds and a random walk of B: steps of a given length [voxels], and rotations that
// move B's rim as far.
struct Walk {
  ContactBody a, b;
  ContactSettings settings;
  double reach;  // radius of B [voxels]
  Random random{5};
  Vec3 way = Vec3::Zero(), axis = Vec3::Zero();

  Vec3 anyWay() { return (2 * random.inCube() - Vec3::Ones()).normalized(); }
  void step(double length) {
    if (random.uniform() < 0.1 || way.isZero()) {
      way = anyWay();
      axis = anyWay();
    }
    b.pose.position += 0.5 * length * kVoxel * way;
    b.pose.orientation = Eigen::AngleAxisd(0.5 * length / reach, axis) * b.pose.orientation;
    b.pose.orientation.normalize();
  }
};

struct Lookups {
  std::size_t listed = 0, fresh = 0;
};

// Queries a finder with lists and a new one, and adds up their lookups.
void query(ContactFinder& finder, const Walk& walk, Lookups& lookups) {
  ContactFinder fresh;
  const ContactResult& want = fresh.find(walk.a, walk.b, walk.settings);
  const ContactResult& got = finder.find(walk.a, walk.b, walk.settings);
  expectSame(got, want, Ids::Ignored);
  lookups.listed += finder.sampleLookups();
  lookups.fresh += fresh.sampleLookups();
}

class VerletLists : public ::testing::Test {
 protected:
  BodyMaker maker{kVoxel, Random(7)};
  Body box = maker.box(Vec3(30, 24, 12)), ball = maker.sphere(14), roller = maker.cylinder(9, 22);

  // B rests on A's upper side, slightly rotated.
  static Walk walk(const Body& a, double height, const Body& b, double below, double reach) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.1, Vec3(1, 2, 0.5).normalized()));
    Walk w{a.at({}), b.at({turn, Vec3(1.3, 0.4, height + below) * kVoxel}), {}, reach};
    w.settings.law = KelvinVoigt{1, 0};
    return w;
  }
  std::vector<Walk> walks() const {
    return {walk(box, 6, ball, 13.5, 14), walk(ball, 14, ball, 13.6, 14),
            walk(box, 6, box, 6.4, 20), walk(roller, 11, box, 6.1, 20)};
  }
};

TEST_F(VerletLists, FindTheSameAtAnySpeed) {
  for (const double margin : {0.0, 0.4})
    for (const double length : {1e-5, 1e-3, 5e-3, 9e-3, 0.03})
      for (Walk w : walks()) {
        w.settings.margin = margin * kVoxel;
        ContactFinder finder;
        Lookups lookups;
        for (int i = 0; i < 60; ++i) {
          w.step(length);
          query(finder, w, lookups);
          if (HasFailure()) return;
        }
        if (length < 2e-3) {
          EXPECT_LT(lookups.listed, lookups.fresh * 7 / 10);
        }
        if (length > 0.02) {
          EXPECT_EQ(lookups.listed, lookups.fresh);
        }
      }
}

// The foundation law looks up all samples.
TEST_F(VerletLists, FindTheSameOfAllSamples) {
  for (Walk w : walks()) {
    w.settings.law = Foundation{1e4, 0};
    ContactFinder finder;
    Lookups lookups;
    for (int i = 0; i < 40; ++i) {
      w.step(2e-3);
      query(finder, w, lookups);
      if (HasFailure()) return;
    }
    EXPECT_LT(lookups.listed, lookups.fresh);
  }
}

// Slowly from contact to separation and back: the list ends on another level than the query.
TEST_F(VerletLists, FindTheSameAsLevelsChange) {
  for (Walk w : walks()) {
    ContactFinder finder;
    Lookups lookups;
    w.settings.margin = 0.3 * kVoxel;
    for (int i = 0; i < 400; ++i) {
      w.b.pose.position.z() += (i < 200 ? 8e-3 : -8e-3) * kVoxel;
      query(finder, w, lookups);
      if (HasFailure()) return;
    }
    EXPECT_LT(lookups.listed, lookups.fresh);
  }
}

// What a list keeps of its coarse samples is what they say if they are asked.
TEST_F(VerletLists, SayWhatTheirSamplesSay) {
  std::size_t kept = 0, asked = 0;
  for (Walk w : walks())
    for (const double length : {2e-3, 8e-3}) {
      cloudcontact::VerletLists lists;
      VerletListBuilder builder;
      const FieldData &a = w.a.field->data(), &b = w.b.field->data();
      for (int i = 0; i < 60; ++i) {
        w.step(length);
        const PairFrame frame = frameOf(w.a, w.b);
        const CcWay ways[2] = {wayOf(w.a, w.b, frame), wayOf(w.b, w.a, frame)};
        if (!lists.begin(a, b, ways, search::kAllSamples)) {
          lists.reserve(0, 10000, 10000);
          if (lists.wanted()) lists.make(a, b, 0, search::kAllSamples, builder);
          continue;
        }
        for (const Side side : {kA, kB}) {
          const FieldData &own = side == kA ? a : b, &other = side == kA ? b : a;
          search::Candidates known, all;
          for (int level = kLevels - 1; level > 0; --level) {
            ASSERT_TRUE(lists.passes(level));
            const search::Direction dir{ways[side],    own, lists.of(side).set, level, side,
                                        float(kVoxel), true};
            lists.of(side).pass(dir, other, lists.age(), known);
            lists.of(side).pass(dir, other, 1e31f, all);  // nothing is known for so long
            ASSERT_EQ(known.runs.size(), all.runs.size());
            for (std::size_t k = 0; k < all.runs.size(); ++k) {
              EXPECT_EQ(known.runs[k].first, all.runs[k].first);
              EXPECT_EQ(known.runs[k].count, all.runs[k].count);
            }
          }
          kept += known.work.samples, asked += all.work.samples;
        }
      }
    }
  EXPECT_LT(kept, asked / 4 * 3);
}

// Other changes between two queries.
TEST_F(VerletLists, AreOfThisPairAlone) {
  Walk w = walk(box, 6, ball, 13.5, 14), other = walk(box, 6, roller, 11, 14);
  ContactFinder finder;
  Lookups lookups;
  const auto rest = [&](Walk& of) {
    for (int i = 0; i < 5; ++i) {
      of.step(1e-4);
      query(finder, of, lookups);
    }
  };
  rest(w);
  rest(other);
  rest(w);
  std::swap(w.a, w.b);
  rest(w);
  std::swap(w.a, w.b);
  w.b.pose.position += Vec3(2.5, -1, 0.4) * kVoxel;  // a jump
  rest(w);
  w.b.pose.position.z() = 20.5 * kVoxel;  // separate, but within the second margin
  w.settings.margin = 0.2 * kVoxel;
  rest(w);
  w.settings.margin = 2 * kVoxel;
  rest(w);
  w.b.pose.position.z() = 19.2 * kVoxel;
  w.settings.samples = 100000;
  rest(w);
  w.settings.samples = 10;
  rest(w);
}

// The same grid and pose, but another surface: a cut body, or a different one.
TEST_F(VerletLists, AreOfTheseFieldsAlone) {
  const auto slab = [](int top) {
    return SurfaceField::build(test::smallCloud(kVoxel, {5, 5, 2}, [=](int x, int y, int z) {
      return x < 2 || y < 2 || z < 2 || x > 37 || y > 37 || z > 10 ? 0 : z == 10 ? top : 255;
    }));
  };
  Walk w = walk(box, 10, ball, 14.0, 14);
  w.b.pose.position += Vec3(20, 20, 0) * kVoxel;
  ContactFinder finder;
  Lookups lookups;
  for (const int top : {60, 250, 100, 20}) {
    const auto field = slab(top);
    w.a = ContactBody{field.get(), nullptr, {}, {}};
    for (int i = 0; i < 4; ++i) {
      w.step(1e-5);
      query(finder, w, lookups);
    }
  }
  EXPECT_LT(lookups.listed, lookups.fresh);
}

}  // namespace
}  // namespace cloudcontact::testing::verlet_list_test
