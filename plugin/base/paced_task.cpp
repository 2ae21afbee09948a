// Two threads that take turns.
#include "base/paced_task.h"

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

namespace cloudcontact {

namespace {

struct Stopped {};  // thrown through work that is no longer wanted

}  // namespace

struct PacedTask::State {
  std::function<void(const Spend&)> work;
  std::mutex mutex;
  std::condition_variable turned;
  bool workers = false;  // whose turn it is: the work's
  bool done = false, stop = false;
  double left = 0;  // of the budget
  std::exception_ptr failure;
  std::thread thread;

  // Gives the turn away and waits until it comes back.
  void swap(bool toWork) {
    std::unique_lock lock(mutex);
    workers = toWork;
    turned.notify_all();
    turned.wait(lock, [&] { return workers != toWork; });
  }
  void main() {
    try {
      work([this](double spent) {
        left -= spent;
        if (left > 0) return;
        swap(false);
        if (stop) throw Stopped();
      });
    } catch (const Stopped&) {
    } catch (...) {
      failure = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    done = true;
    workers = false;
    turned.notify_all();
  }
  void turn() {
    if (!thread.joinable()) {
      workers = true;
      thread = std::thread([this] { main(); });
      std::unique_lock lock(mutex);
      turned.wait(lock, [&] { return !workers; });
    } else {
      swap(true);
    }
    if (done) thread.join();
  }
};

PacedTask::PacedTask(std::function<void(const Spend&)> work) : state_(std::make_unique<State>()) {
  state_->work = std::move(work);
}

PacedTask::~PacedTask() {
  if (!state_ || !state_->thread.joinable()) return;
  state_->stop = true;
  while (!state_->done) state_->turn();
}

PacedTask::PacedTask(PacedTask&&) noexcept = default;
PacedTask& PacedTask::operator=(PacedTask&& other) noexcept {
  std::swap(state_, other.state_);
  return *this;
}

double PacedTask::run(double budget) {
  if (state_->done) return budget;
  state_->left = budget;
  state_->turn();
  if (state_->failure) std::rethrow_exception(std::exchange(state_->failure, nullptr));
  return state_->left;
}

bool PacedTask::done() const {
  return state_->done;
}

}  // namespace cloudcontact
