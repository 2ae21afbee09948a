// A kernel that is run again and again with nearly the same arguments.
#pragma once

#include "device/opencl.h"

#include <concepts>
#include <cstdint>
#include <utility>
#include <vector>

namespace cloudcontact::opencl {

// Remembers what it was given, and hands over only what is new: a batch has a hundred arguments and
// is handed over in 300 us, which its device waits for. It holds on to the buffers, so that no
// other takes the place of one that it remembers.
class PreparedKernel {
 public:
  explicit PreparedKernel(cl::Kernel kernel) : kernel_(std::move(kernel)) {}

  // All of its arguments.
  template <typename... Arguments>
  cl::Kernel& give(const Arguments&... arguments) {
    given_.resize(sizeof...(arguments));
    cl_uint k = 0;
    (set(k++, arguments), ...);
    return kernel_;
  }

 private:
  struct Given {
    bool is = false;
    std::int64_t number = 0;
    cl::Buffer buffer;
  };

  void set(cl_uint k, const cl::Buffer& buffer) {
    if (given_[k].is && given_[k].buffer() == buffer()) return;
    hand(k, buffer);
    given_[k].buffer = buffer;
  }
  void set(cl_uint k, std::integral auto number) {
    if (given_[k].is && given_[k].number == std::int64_t{number}) return;
    hand(k, number);
    given_[k].number = number;
  }
  template <typename Argument>
  void hand(cl_uint k, const Argument& argument) {
    given_[k].is = false;  // where it throws, too
    kernel_.setArg(k, argument);
    given_[k].is = true;
  }

  cl::Kernel kernel_;
  std::vector<Given> given_;
};

}  // namespace cloudcontact::opencl
