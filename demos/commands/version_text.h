// What `cloudcontact --version` prints.
#pragma once

#include <string>

namespace cloudcontact::program {

// A line each: the version, Bullet's version and precision, the vector instructions in use, and the
// OpenCL devices.
std::string versionText();

}  // namespace cloudcontact::program
