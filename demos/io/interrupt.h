// Ctrl-C as a question, for work that ends in good order.
#pragma once

namespace cloudcontact::program {

// While it lives, the first Ctrl-C (or SIGTERM) is noted and the program goes on; a second one ends
// it as ever. One at a time.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  bool came() const;

 private:
  using Handler = void (*)(int);
  Handler interrupt_, terminate_;  // those before
};

}  // namespace cloudcontact::program
