// Work in slices: it stops where a budget ends, goes on from there, and can be given up.
#include "base/paced_task.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

namespace cloudcontact::paced_task_test {
namespace {

TEST(PacedTask, StopsWhereTheBudgetEnds) {
  int done = 0;
  PacedTask task([&](const PacedTask::Spend& spend) {
    for (int k = 0; k < 10; ++k) {
      ++done;
      spend(2);
    }
  });
  EXPECT_EQ(done, 0);
  EXPECT_EQ(task.run(5), -1);  // three parts of 2
  EXPECT_EQ(done, 3);
  EXPECT_EQ(task.run(2), 0);
  EXPECT_EQ(done, 4);
  EXPECT_FALSE(task.done());
  EXPECT_EQ(task.run(100), 88);
  EXPECT_EQ(done, 10);
  EXPECT_TRUE(task.done());
  EXPECT_EQ(task.run(7), 7);
}

TEST(PacedTask, IsDoneWithoutSpending) {
  bool done = false;
  PacedTask task([&](const PacedTask::Spend&) { done = true; });
  EXPECT_EQ(task.run(1), 1);
  EXPECT_TRUE(done && task.done());
}

TEST(PacedTask, PassesOnWhatIsThrown) {
  PacedTask task([](const PacedTask::Spend& spend) {
    spend(1);
    throw std::invalid_argument("no");
  });
  EXPECT_EQ(task.run(1), 0);
  EXPECT_THROW(task.run(1), std::invalid_argument);
  EXPECT_TRUE(task.done());
}

TEST(PacedTask, EndsWhenItIsNoLongerWanted) {
  struct Alive {
    int& count;
    explicit Alive(int& c) : count(c) { ++count; }
    ~Alive() { --count; }
  };
  int alive = 0, parts = 0;
  {
    PacedTask task([&](const PacedTask::Spend& spend) {
      const Alive one(alive);
      for (;;) {
        ++parts;
        spend(1);
      }
    });
    task.run(3);
    EXPECT_EQ(alive, 1);
    PacedTask moved(std::move(task));
    moved.run(2);
  }
  EXPECT_EQ(alive, 0);
  EXPECT_EQ(parts, 5);
}

}  // namespace
}  // namespace cloudcontact::paced_task_test
