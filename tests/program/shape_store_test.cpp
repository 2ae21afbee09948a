// What worlds share is made once, again if it failed, and not kept for ever.
#include "scene/shape_store.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace cloudcontact::program::shape_store_test {
namespace {

using Number = std::shared_ptr<const int>;

struct Numbers {
  KeptOnce<Number> kept;
  int made = 0;
  Number get(int n) {
    return kept.get(std::to_string(n), [&] {
      ++made;
      return std::make_shared<const int>(n);
    });
  }
};

TEST(KeptOnce, MakesEachValueOnce) {
  Numbers numbers;
  const Number one = numbers.get(1);
  EXPECT_EQ(numbers.get(1), one);
  EXPECT_EQ(*numbers.get(2), 2);
  EXPECT_EQ(numbers.made, 2);
}

TEST(KeptOnce, MakesWhatFailedAgain) {
  KeptOnce<Number> kept;
  const auto fails = []() -> Number { throw std::runtime_error("not now"); };
  EXPECT_THROW(kept.get("a", fails), std::runtime_error);
  EXPECT_THROW(kept.get("a", fails), std::runtime_error);
  EXPECT_EQ(*kept.get("a", [] { return std::make_shared<const int>(3); }), 3);
}

TEST(KeptOnce, DropsWhatWasNotAskedForLongAndNobodyUses) {
  Numbers numbers;
  const Number used = numbers.get(0);
  for (int n = 1; n <= 5; ++n) numbers.get(n);
  numbers.get(1);  // asked for again, after 2 to 5
  numbers.kept.trim(2);
  EXPECT_EQ(numbers.made, 6);
  for (const int n : {0, 1, 5}) numbers.get(n);
  EXPECT_EQ(numbers.made, 6);
  for (const int n : {2, 3, 4}) numbers.get(n);
  EXPECT_EQ(numbers.made, 9);
  EXPECT_EQ(numbers.get(0), used);
}

TEST(ShapeStore, AStoreOutlivesItsWorlds) {
  auto first = commonStore();
  const std::weak_ptr<ShapeStore> life = first;
  first.reset();
  EXPECT_EQ(commonStore(), life.lock());
}

}  // namespace
}  // namespace cloudcontact::program::shape_store_test
