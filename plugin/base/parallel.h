// A parallel loop over independent tasks. The core depends on nothing but Eigen and threads, and
// all that it needs is this: tasks handed out by a counter, results kept apart by the task's index,
// so that the outcome is the same for any number of threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace cloudcontact {

// Number of threads to run where a setting says `asked` (0: all cores).
inline int threadCount(int asked) {
  if (asked > 0) return asked;
  const unsigned cores = std::thread::hardware_concurrency();
  return cores > 0 ? static_cast<int>(cores) : 1;
}

// Calls task(index, worker) for every index in [0, count), worker in [0, threadCount(threads)).
// Worker 0 is the calling thread. The first exception stops the loop and is thrown here.
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
    const std::size_t wanted = static_cast<std::size_t>(threadCount(threads));
    for (std::size_t w = 1; w < wanted && w < count; ++w)
      helpers.emplace_back(work, static_cast<int>(w));
    work(0);
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace cloudcontact
