// Whether a test may do without an OpenCL device. On a machine that has none at all it may, unless
// CLOUDCONTACT_NEEDS_OPENCL is set, as script/test does, which installs one; where a device is
// refused it may never.
#pragma once

#include <cstdlib>
#include <string>

namespace cloudcontact::test {

template <typename Runner>  // ContactBatch, Digitizer
bool mayDoWithout(const Runner& runner) {
  return runner.message().find("no OpenCL device; install") != std::string::npos &&
         std::getenv("CLOUDCONTACT_NEEDS_OPENCL") == nullptr;
}

}  // namespace cloudcontact::test
