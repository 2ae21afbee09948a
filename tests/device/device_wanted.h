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

// Ends a test where there is no device and may be none; anything but a device's answers fails it.
#define SKIP_WITHOUT(runner)                                                      \
  if (cloudcontact::test::mayDoWithout(runner)) GTEST_SKIP() << runner.message(); \
  ASSERT_EQ(runner.backend(), cloudcontact::Backend::OpenCl) << runner.message()
