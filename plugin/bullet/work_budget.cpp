// Least harm first; back in the opposite order where there is room.
#include "bullet/work_budget.h"

#include <algorithm>

namespace cloudcontact {

namespace {

constexpr double kSaved = 0.5;  // of a pair's work, with voxels twice as large; a careful guess
constexpr double kRoom = 0.7;   // of the budget, for a pair that gets finer again ...
constexpr double kMore = 4;     // ... and then works this much more at most
constexpr int kQuiet = 30;      // steps between two such pairs

}  // namespace

void WorkBudget::add(Pair& pair) {
  const std::lock_guard lock(mutex_);
  pairs_.push_back(&pair);
}

void WorkBudget::remove(Pair& pair) {
  const std::lock_guard lock(mutex_);
  std::erase(pairs_, &pair);
}

void WorkBudget::open(Pair& pair) {
  const std::lock_guard lock(mutex_);
  if (pair.step != step_) return;
  shareOut();
  ++step_;
}

void WorkBudget::shareOut() {
  std::vector<Pair*> now;
  for (Pair* const pair : pairs_)
    if (pair->step == step_) now.push_back(pair);
  std::sort(now.begin(), now.end(), [](const Pair* x, const Pair* y) {
    return x->harm != y->harm ? x->harm < y->harm : x->name < y->name;
  });
  double sum = 0;  // in that order, so rounding repeats
  for (const Pair* const pair : now) sum += pair->seconds;
  last_ = sum;
  ++quiet_;
  for (Pair* const pair : now) {
    if (sum <= budget_) break;
    if (!pair->canEase) continue;
    pair->ease += 1;
    sum -= kSaved * pair->seconds;
    quiet_ = 0;
  }
  if (quiet_ < kQuiet) return;
  for (auto it = now.rbegin(); it != now.rend(); ++it) {
    Pair& pair = **it;
    if (pair.ease == 0 || sum + (kMore - 1) * pair.seconds > kRoom * budget_) continue;
    pair.ease -= 1;
    quiet_ = 0;
    return;
  }
}

}  // namespace cloudcontact
