// A parallel loop over independent tasks, without a dependency beyond the standard library. Threads
// draw tasks from a counter and store results by the task's index, so the outcome does not depend
// on the number of threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace cloudcontact {

// Number of threads for a setting of `requested` (0: all cores).
inline int threadCount(int requested) {
  if (requested > 0) return requested;
  const unsigned cores = std::thread::hardware_concurrency();
  return cores > 0 ? static_cast<int>(cores) : 1;
}

// Calls task(index, worker) for every index in [0, count), worker in [0, threadCount(threads)).
// Worker 0 is the calling thread. The first exception stops the loop and is rethrown here.
template <typename Task>
void parallelFor(std::size_t count, int threads, Task&& task) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failureMutex;
  const auto work = [&](int worker) {
    try {
      for (std::size_t i = next++; i < count; i = next++) task(i, worker);
    } catch (...) {
      next = count;
      const std::lock_guard lock(failureMutex);
      if (!failure) failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> helpers;
    const std::size_t workers = std::min<std::size_t>(threadCount(threads), count);
    for (std::size_t w = 1; w < workers; ++w) helpers.emplace_back(work, static_cast<int>(w));
    work(0);
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace cloudcontact
