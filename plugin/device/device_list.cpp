// The list of devices, which is empty without OpenCL.
#include <cloudcontact/device/device_list.h>

#if defined(CLOUDCONTACT_OPENCL)
#include "device/opencl_device.h"
#endif

namespace cloudcontact {

std::vector<std::string> openClDevices() {
#if defined(CLOUDCONTACT_OPENCL)
  return opencl::Device::names();
#else
  return {};
#endif
}

}  // namespace cloudcontact
