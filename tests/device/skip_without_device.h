// Whether a test may skip for want of an OpenCL device. It may on a machine without any, unless
// CLOUDCONTACT_NEEDS_OPENCL is set (script/test sets it, after installing a device). It may not if
// a device was rejected.
#pragma once

#include <cstdlib>
#include <string>

namespace cloudcontact::test {

// `why` a device is not used.
inline bool maySkip(const std::string& why) {
  const bool none = why.find("no OpenCL device; install") != std::string::npos ||
                    why.find("built without OpenCL; install") != std::string::npos;
  return none && std::getenv("CLOUDCONTACT_NEEDS_OPENCL") == nullptr;
}

template <typename Runner>  // ContactBatch, Digitizer or DeviceWorkpiece
bool maySkip(const Runner& runner) {
  return maySkip(runner.message());
}

}  // namespace cloudcontact::test

// Skips a test if there is no device and it may; fails it if the device is not used.
#define SKIP_WITHOUT(runner)                                                 \
  if (cloudcontact::test::maySkip(runner)) GTEST_SKIP() << runner.message(); \
  ASSERT_EQ(runner.backend(), cloudcontact::Backend::OpenCl) << runner.message()
