// Lines of threads before objects (turns.h).
#include "python/turns.h"

#include <pybind11/pybind11.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

namespace cloudcontact::python {
namespace {

namespace py = pybind11;
constexpr auto kListens = std::chrono::milliseconds(50);  // between looks at Ctrl-C

struct Place {
  std::thread::id thread;
  std::uint64_t ticket;
};

// The lines before all objects that are in use; the first in a line has the object.
struct Lines {
  std::mutex mutex;
  std::condition_variable moved;
  std::map<const void*, std::vector<Place>> of;
  std::uint64_t tickets = 0;

  bool isFirst(const void* object, std::uint64_t ticket) {
    return of.at(object).front().ticket == ticket;
  }
  std::uint64_t join(const void* object) {
    const std::lock_guard lock(mutex);
    std::vector<Place>& line = of[object];
    if (!line.empty() && line.front().thread == std::this_thread::get_id())
      throw std::runtime_error("this thread uses the object already; do not use it in a callback");
    line.push_back({std::this_thread::get_id(), ++tickets});
    return tickets;
  }
  // Whether it is this ticket's turn, within a while.
  bool await(const void* object, std::uint64_t ticket) {
    std::unique_lock lock(mutex);
    return moved.wait_for(lock, kListens, [&] { return isFirst(object, ticket); });
  }
  void leave(const void* object, std::uint64_t ticket) {
    const std::lock_guard lock(mutex);
    const auto at = of.find(object);
    std::vector<Place>& line = at->second;
    line.erase(std::find_if(line.begin(), line.end(),
                            [&](const Place& place) { return place.ticket == ticket; }));
    if (line.empty()) of.erase(at);
    moved.notify_all();
  }
};

// Never deleted: a thread may wait when the process ends.
Lines& lines() {
  static Lines& all = *new Lines;
  return all;
}

bool awaitUnlocked(const void* object, std::uint64_t ticket) {
  if (PyGILState_Check() == 0) return lines().await(object, ticket);
  const Unlocked unlocked;
  return lines().await(object, ticket);
}

}  // namespace

Turn::Turn(const void* object) : object_(object), ticket_(lines().join(object)) {
  {
    const std::lock_guard lock(lines().mutex);
    if (lines().isFirst(object_, ticket_)) return;
  }
  while (!awaitUnlocked(object_, ticket_))
    if (PyGILState_Check() != 0 && PyErr_CheckSignals() != 0) {
      lines().leave(object_, ticket_);
      throw py::error_already_set();
    }
}

Turn::~Turn() {
  lines().leave(object_, ticket_);
}

}  // namespace cloudcontact::python
