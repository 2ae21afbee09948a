// Whether a test may do without an OpenCL device. On a machine that has none at all it may, unless
// CLOUDCONTACT_NEEDS_OPENCL is set, as script/test does, which installs one; where a device is
// refused it may never.
#pragma once

#include <cloudcontact/batch.h>

#include <cstdlib>

namespace cloudcontact::test {

inline bool mayDoWithout(const ContactBatch& batch) {
  return batch.message().find("no OpenCL device; install") != std::string::npos &&
         std::getenv("CLOUDCONTACT_NEEDS_OPENCL") == nullptr;
}

}  // namespace cloudcontact::test
