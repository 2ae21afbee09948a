// Two pieces of work at the same time.
#pragma once

#include <future>
#include <utility>

namespace cloudcontact::program {

// What `a` and `b` return. `b` runs on a thread of its own unless `threads` is 1. Where both throw,
// a's exception is thrown, as if they ran in turn.
template <class A, class B>
auto bothOf(int threads, A a, B b) {
  auto second = std::async(threads == 1 ? std::launch::deferred : std::launch::async, std::move(b));
  auto first = a();
  return std::pair(std::move(first), second.get());
}

}  // namespace cloudcontact::program
