// Asks the library, Bullet and OpenCL for their versions.
#include "commands/version_text.h"

#include <LinearMath/btScalar.h>
#include <cloudcontact/device/device_list.h>
#include <cloudcontact/version.h>

#include <string>

namespace cloudcontact::program {

std::string versionText() {
  std::string devices;
  for (const std::string& name : openClDevices()) devices += (devices.empty() ? "" : "; ") + name;
  const int bullet = btGetVersion();
  const int minor = bullet % 100;
  return "cloudcontact " + std::string(version()) + "\nBullet " + std::to_string(bullet / 100) +
         (minor < 10 ? ".0" : ".") + std::to_string(minor) + " in " +
         (sizeof(btScalar) == sizeof(float) ? "float" : "double") +
         "\nvector instructions: " + std::string(vectorInstructions()) +
         "\nOpenCL devices: " + (devices.empty() ? "none" : devices);
}

}  // namespace cloudcontact::program
