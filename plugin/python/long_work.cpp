// Work without Python's lock (long_work.h).
#include "python/long_work.h"

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include "python/raised_errors.h"
#include "python/unlocked.h"

namespace cloudcontact::python {
namespace {

constexpr auto kLook = std::chrono::milliseconds(50);  // between looks at Ctrl-C

// Ends work that Python no longer wants. No std::exception, so that nobody on the way translates
// it.
struct Unwanted {};

struct Run {
  std::atomic<double> share{0};
  std::atomic<bool> unwanted{false};
  std::mutex mutex;
  std::condition_variable changed;
  bool done = false;
  std::exception_ptr failure;

  void work(const std::function<void(const std::function<void(double)>&)>& task) {
    try {
      task([this](double now) {
        share = now;
        if (unwanted) throw Unwanted{};
      });
    } catch (...) {
      failure = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    done = true;
    changed.notify_one();
  }
  bool waitAWhile() {
    const Unlocked unlocked;
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, kLook, [this] { return done; });
  }
};

py::object reporterOf(const py::object& progress, const std::string& label) {
  return py::module_::import("cloudcontact._progress").attr("reporter")(progress, textOf(label));
}

void lookAndReport(const py::object& reporter, double share) {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  if (!reporter.is_none()) reporter(share);
}

}  // namespace

void runLong(const py::object& progress, const std::string& label,
             const std::function<void(const std::function<void(double)>&)>& work) {
  const py::object reporter = reporterOf(progress, label);
  Run run;
  std::optional<py::error_already_set> raised;
  std::optional<Claim> claim(std::in_place);  // the work ends before the process does
  std::thread thread([&] { run.work(work); });
  while (!run.waitAWhile()) {
    if (interpreterEnds()) run.unwanted = true;
    if (raised) continue;
    try {
      lookAndReport(reporter, run.share);
    } catch (py::error_already_set& error) {
      raised.emplace(error);
      run.unwanted = true;
    }
  }
  thread.join();
  claim.reset();
  { const Claim stops; }  // here, where the interpreter ends
  if (raised) throw py::error_already_set(*raised);
  if (run.failure) std::rethrow_exception(run.failure);
  if (!reporter.is_none()) reporter(1.0);
}

Pacer::Pacer(const py::object& progress, const std::string& label)
    : reporter_(reporterOf(progress, label)) {}

void Pacer::report(double share) {
  const auto now = std::chrono::steady_clock::now();
  if (now - last_ < kLook) return;
  last_ = now;
  const Locked locked;
  lookAndReport(reporter_, share);
}

void Pacer::finish() {
  if (!reporter_.is_none()) reporter_(1.0);
}

}  // namespace cloudcontact::python
