// The OpenCL devices of this machine.
#pragma once

#include <string>
#include <vector>

namespace cloudcontact {

// Their names in the order in which they are tried, GPUs first; after the name of one that cannot
// be used stands why, in parentheses. Kernels are not compiled, so a device may still turn out to
// round differently from the CPU. Empty if there are none, or in a library built without OpenCL.
std::vector<std::string> openClDevices();

}  // namespace cloudcontact
