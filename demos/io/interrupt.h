// Ctrl-C and a closed terminal as a question, for work that ends in good order.
#pragma once

namespace cloudcontact::program {

// While it lives, the first Ctrl-C (or SIGTERM) is noted and the program goes on; a second one ends
// it as ever. So is the loss of the terminal (SIGHUP), of which the shell and the system both tell:
// from the first on it is ignored, for good, so that the work that is left gets done. One that is
// ignored at the start, as under nohup, stays so. One at a time.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  bool came() const;

 private:
  using Handler = void (*)(int);
  Handler interrupt_, terminate_, hangup_;  // those before
};

}  // namespace cloudcontact::program
