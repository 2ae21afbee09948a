// WorkBudget: makes pairs coarser where those of a step would take longer than a world allows
// (Fidelity::budget). It counts work, so that equal input gives equal results on any machine and
// any number of threads.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

namespace cloudcontact {

class WorkBudget {
 public:
  // A pair's part, written by the pair itself.
  struct Pair {
    std::array<int, 4> name{};  // orders pairs; not by the order in which threads made them
    double seconds = 0;         // counted, of its last step
    double harm = 0;            // [kg m] mass times error
    int ease = 0;               // levels coarser; set by the budget
    bool canEase = true;
    std::uint64_t step = 0;  // the last step in which it was processed
  };

  explicit WorkBudget(double seconds) : budget_(seconds) {}
  bool isLimited() const { return budget_ > 0; }

  void add(Pair& pair);
  void remove(Pair& pair);
  // Before a pair's query in a step. The first pair that comes back opens the step, and all pairs
  // are shared out by the last one's work.
  void open(Pair& pair);
  // After it.
  void close(Pair& pair) {
    const std::lock_guard lock(mutex_);
    pair.step = step_;
  }
  double lastStep() const {  // [s] counted, of all pairs
    const std::lock_guard lock(mutex_);
    return last_;
  }

 private:
  void shareOut();

  double budget_;
  mutable std::mutex mutex_;
  std::uint64_t step_ = 1;
  int quiet_ = 0;  // steps since a pair has changed
  double last_ = 0;
  std::vector<Pair*> pairs_;
};

}  // namespace cloudcontact
