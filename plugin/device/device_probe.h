// What an OpenCL device can do at most: the floors that a batch's steps are measured against.
#pragma once

#include <string>

namespace cloudcontact {

struct DeviceSpeeds {
  std::string device;
  double copy = 0;      // [bytes/s] read and written by a kernel that copies 16 bytes an item
  double gather = 0;    // [1/s] 8-byte records fetched from random places of 16 MB
  double doubles = 0;   // [1/s] sums and products of doubles, not contracted
  double upload = 0;    // [bytes/s] from pinned memory
  double download = 0;  // [bytes/s] to it
  double launch = 0;    // [s] from handing over an empty kernel to having waited for it
};

// Throws std::runtime_error where there is no device.
DeviceSpeeds measureDevice();

}  // namespace cloudcontact
