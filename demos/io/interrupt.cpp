// Notes a signal (interrupt.h). A handler can reach nothing but a static variable.
#include "io/interrupt.h"

#include <csignal>

namespace cloudcontact::program {
namespace {

volatile std::sig_atomic_t interruptCame = 0;

extern "C" void noteInterrupt(int number) {
  interruptCame = 1;
  std::signal(number, SIG_DFL);
}

}  // namespace

Interrupt::Interrupt() {
  interruptCame = 0;
  interrupt_ = std::signal(SIGINT, noteInterrupt);
  terminate_ = std::signal(SIGTERM, noteInterrupt);
}

Interrupt::~Interrupt() {
  std::signal(SIGINT, interrupt_);
  std::signal(SIGTERM, terminate_);
}

bool Interrupt::came() const {
  return interruptCame != 0;
}

}  // namespace cloudcontact::program
