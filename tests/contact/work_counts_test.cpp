// The counts of what a contact took: what they must be by hand, and that they do not depend on
// threads. tests/contact/lane_bits.cpp shows that they do not depend on the width of vectors.
#include <cloudcontact/contact/contact_finder.h>
#include <gtest/gtest.h>

#include <thread>

#include "contact/contact_cases.h"

namespace cloudcontact::testing::work_counts_test {
namespace {

constexpr double kVoxel = 1e-3;

// Each task in a thread of its own.
void onThreads(int count, const std::function<void(int)>& task) {
  std::vector<std::thread> threads;
  for (int i = 0; i < count; ++i) threads.emplace_back([&task, i] { task(i); });
  for (std::thread& thread : threads) thread.join();
}

class WorkCountsOfPair : public ::testing::Test {
 protected:
  BodyMaker maker{kVoxel, Random(11)};
  Body slab = maker.box(Vec3(120, 120, 16)), ball = maker.sphere(20),
       block = maker.box(Vec3(40, 40, 18));
  ContactSettings settings;
  ContactResult found;  // of the last search

  WorkCountsOfPair() { settings.law = KelvinVoigt{1, 0}; }

  // `height` [voxels] between the slab's upper side and the middle of the other body.
  WorkCounts workAt(const Body& other, double height, ContactFinder& finder,
                    const TaskRunner* runner = nullptr) {
    const WorkCounts before = finder.work();
    finder.search(slab.at({}),
                  other.at({Eigen::Quaterniond::Identity(), Vec3(0.3, 0.2, 8 + height) * kVoxel}),
                  settings, found, runner);
    WorkCounts work = finder.work();
    work -= before;
    return work;
  }
};

TEST_F(WorkCountsOfPair, NothingFarApart) {
  ContactFinder finder;
  EXPECT_EQ(workAt(ball, 200, finder), WorkCounts{});
}

TEST_F(WorkCountsOfPair, OneSearchForATouchTwoForANearMiss) {
  ContactFinder finder;
  const WorkCounts touch = workAt(ball, 19, finder);
  EXPECT_EQ(touch.searches, 1u);
  EXPECT_GT(touch.hits, 0u);
  EXPECT_EQ(touch.samples, finder.sampleLookups());
  EXPECT_GE(touch.hits, found.samples);
  settings.margin = kVoxel;
  const WorkCounts near = workAt(ball, 20.5, finder);
  EXPECT_EQ(near.searches, 2u);
  EXPECT_EQ(near.samples, finder.sampleLookups());
}

// A touch is placed from all its hits: each of five lookups at least goes through a bin.
TEST_F(WorkCountsOfPair, PointsAreFoundAmongTheHits) {
  ContactFinder finder;
  const WorkCounts work = workAt(block, 8.5, finder);
  ASSERT_EQ(found.patches.size(), 1u);
  EXPECT_GT(work.scanned, 5u);
  EXPECT_GE(work.tried, 5u);
}

TEST_F(WorkCountsOfPair, EqualOnAnyThreads) {
  settings.samples = 1u << 20;  // all, so that levels are large enough to be shared out
  ContactFinder alone, shared;
  const Body wide = maker.box(Vec3(110, 110, 18));
  int levels = 0;  // that were shared out
  const TaskRunner runner = [&](int count, const std::function<void(int)>& task) {
    ++levels;
    onThreads(count, task);
  };
  for (const double height : {8.5, 8.7, 8.9, 9.4}) {
    const WorkCounts one = workAt(wide, height, alone),
                     many = workAt(wide, height, shared, &runner);
    EXPECT_EQ(one, many) << height;
  }
  EXPECT_GT(levels, 4);
}

TEST_F(WorkCountsOfPair, AWorkspaceSumsItsFinders) {
  const auto workspace = std::make_shared<ContactWorkspace>();
  ContactFinder first(workspace), second(workspace);
  WorkCounts sum = workAt(ball, 19, first);
  sum += workAt(block, 8.5, second);
  EXPECT_EQ(workspace->work(), sum);
}

}  // namespace
}  // namespace cloudcontact::testing::work_counts_test
