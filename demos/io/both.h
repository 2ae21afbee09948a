// Two pieces of work at the same time.
#pragma once

#include <future>
#include <utility>

namespace cloudcontact::program {

// Whether bothOf() runs its work at the same time: where the user leaves the number of threads to
// the program (0). Each piece of work then may use all cores.
inline bool runsBoth(int threads) {
  return threads == 0;
}

// What `a` and `b` return, at the same time or in turn. Where both throw, a's exception is thrown.
template <class A, class B>
auto bothOf(int threads, A a, B b) {
  auto second =
      std::async(runsBoth(threads) ? std::launch::async : std::launch::deferred, std::move(b));
  auto first = a();
  return std::pair(std::move(first), second.get());
}

}  // namespace cloudcontact::program
