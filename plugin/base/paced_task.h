// PacedTask: work that runs in slices, so that it holds no step of a simulation for long. The work
// says as it goes along how much it has done, and stops where a slice's budget ends: by counts,
// never by a clock, so that every run is the same. It runs on a thread of its own that takes turns
// with its caller; only one of the two is running. A thread can stop anywhere down its calls, which
// leaves the work's functions as they are.
#pragma once

#include <functional>
#include <memory>

namespace cloudcontact {

class PacedTask {
 public:
  // Called by the work, on the work's own thread, after each part of it [about microseconds].
  using Spend = std::function<void(double done)>;

  // The work starts with the first slice.
  explicit PacedTask(std::function<void(const Spend&)> work);
  ~PacedTask();  // the work ends at its next Spend, by an exception that passes through it
  PacedTask(PacedTask&&) noexcept;
  PacedTask& operator=(PacedTask&&) noexcept;

  // Goes on until a budget is spent or the work is done. Returns what is left of the budget: 0 or
  // less if it was spent. Rethrows what the work has thrown; it is done then.
  double run(double budget);
  bool done() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
