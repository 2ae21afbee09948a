// A function that Python calls before its end waits until all scopes are left.
#include "python/unlocked.h"

#include <atomic>
#include <chrono>
#include <thread>

namespace py = pybind11;

namespace cloudcontact::python {
namespace {

using Clock = std::chrono::steady_clock;

// Work looks at interpreterEnds() after a step, or a report of its progress. What takes longer than
// this is left behind.
constexpr auto kLongest = std::chrono::seconds(20);
constexpr auto kBetween = std::chrono::milliseconds(5);
constexpr int kQuiet = 20;  // looks

std::atomic<int> claims{0};
std::atomic<bool> ending{false};
std::atomic<std::thread::id> ender;
thread_local int ownClaims = 0;

// The process ends with the main thread, and this one with it.
[[noreturn]] void stay() {
  for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
}

bool isGone() {
#if PY_VERSION_HEX >= 0x030D0000
  return Py_IsFinalizing() != 0;
#else
  return _Py_IsFinalizing() != 0;
#endif
}

void waitForAll() {
  ender = std::this_thread::get_id();
  ending = true;
  const int others = py::module_::import("threading").attr("active_count")().cast<int>() - 1;
  const auto until = Clock::now() + kLongest;
  // Threads on the way from one scope to the next come there meanwhile, and stop.
  int quiet = others > 0 ? kQuiet : 0;
  while ((claims > 0 || quiet > 0) && Clock::now() < until) {
    PyThreadState* const state = PyEval_SaveThread();
    std::this_thread::sleep_for(kBetween);
    PyEval_RestoreThread(state);
    quiet = claims > 0 ? kQuiet : quiet - 1;
  }
}

// Before a member takes the lock.
py::gil_scoped_acquire lockUnlessGone() {
  if (isGone() && interpreterEnds()) stay();
  return {};
}

}  // namespace

bool interpreterEnds() {
  return ending && std::this_thread::get_id() != ender.load();
}

Claim::Claim() {
  if (ownClaims == 0 && interpreterEnds() && PyGILState_Check() != 0) {
    PyEval_SaveThread();
    stay();
  }
  ++claims, ++ownClaims;
}

Claim::~Claim() {
  --claims, --ownClaims;
}

Unlocked::Unlocked() : state_(PyEval_SaveThread()) {}

Unlocked::~Unlocked() {
  if (isGone() && interpreterEnds()) stay();
  PyEval_RestoreThread(state_);
}

Locked::Locked() : locked_(lockUnlessGone()) {}

void waitAtExit() {
  py::module_::import("atexit").attr("register")(py::cpp_function(&waitForAll));
}

}  // namespace cloudcontact::python
