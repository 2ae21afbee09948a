// One thread at a time: objects of Python that change, or keep memory for their work, while other
// threads of Python run.
#pragma once

#include <cstdint>

#include "python/unlocked.h"

namespace cloudcontact::python {

// The right to use an object until the end of the scope. Threads get it in the order in which they
// ask, so that one that steps a world lets others read it. Who takes two takes the workpiece's
// last.
class Turn {
 public:
  // Waits, without Python's lock, until no other thread has the object; where Python's lock was
  // held, it listens to Ctrl-C meanwhile. Throws what Ctrl-C raises, and std::runtime_error where
  // this thread has the object, as in a callback of its own work.
  explicit Turn(const void* object);
  ~Turn();
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  Claim claim_;
  const void* object_;
  std::uint64_t ticket_ = 0;
};

}  // namespace cloudcontact::python
