// Notes a signal (interrupt.h). A handler can reach nothing but a static variable.
#include "io/interrupt.h"

#include <signal.h>

#include <csignal>

namespace cloudcontact::program {
namespace {

volatile std::sig_atomic_t interruptCame = 0, hangupCame = 0;

extern "C" void noteInterrupt(int number) {
  interruptCame = 1;
  std::signal(number, SIG_DFL);
}

extern "C" void noteHangup(int) {
  hangupCame = 1;
  interruptCame = 1;
  std::signal(SIGHUP, SIG_IGN);
}

}  // namespace

Interrupt::Interrupt() {
  interruptCame = 0;
  hangupCame = 0;
  interrupt_ = std::signal(SIGINT, noteInterrupt);
  terminate_ = std::signal(SIGTERM, noteInterrupt);
  struct sigaction now;
  sigaction(SIGHUP, nullptr, &now);  // looks: one that is ignored must not be noted for a moment
  hangup_ = now.sa_handler;
  if (hangup_ != SIG_IGN) std::signal(SIGHUP, noteHangup);
}

Interrupt::~Interrupt() {
  std::signal(SIGINT, interrupt_);
  std::signal(SIGTERM, terminate_);
  if (!hangupCame) std::signal(SIGHUP, hangup_);
}

bool Interrupt::came() const {
  return interruptCame != 0;
}

}  // namespace cloudcontact::program
