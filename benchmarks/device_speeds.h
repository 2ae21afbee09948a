// Peak speeds of an OpenCL device, as a bound for the kernels' times.
#pragma once

#include <string>

namespace cloudcontact {

struct DeviceSpeeds {
  std::string device;
  double copy = 0;      // [bytes/s] read and written by a kernel that copies 16 bytes an item
  double gather = 0;    // [1/s] 8-byte records read from random places in 16 MB
  double doubles = 0;   // [1/s] additions and multiplications of doubles, not contracted
  double upload = 0;    // [bytes/s] from pinned memory
  double download = 0;  // [bytes/s] to pinned memory
  double launch = 0;    // [s] from enqueueing an empty kernel to the end of the wait for it
};

// Throws std::runtime_error if there is no device.
DeviceSpeeds measureDevice();

}  // namespace cloudcontact
