// What callers are told where a device fails: none of OpenCL's own errors, which are no
// std::runtime_error, leave this folder.
#pragma once

#include "device/opencl.h"

#include <new>
#include <stdexcept>
#include <string>

namespace cloudcontact::opencl {

inline std::runtime_error failure(const std::string& device, const cl::Error& e) {
  return std::runtime_error("OpenCL: " + device + " failed: " + e.what() + " gave " +
                            std::to_string(e.err()));
}

// Does some work on a device. Throws std::runtime_error that names the device where that fails.
template <typename Work>
decltype(auto) guarded(const std::string& device, Work&& work) {
  try {
    return work();
  } catch (const cl::Error& e) {
    throw failure(device, e);
  }
}

// The same for work that the CPU may do instead: std::bad_alloc where the device has no room.
template <typename Work>
decltype(auto) guardedForRoom(const std::string& device, Work&& work) {
  try {
    return work();
  } catch (const cl::Error& e) {
    if (e.err() == CL_MEM_OBJECT_ALLOCATION_FAILURE || e.err() == CL_OUT_OF_RESOURCES)
      throw std::bad_alloc();
    throw failure(device, e);
  }
}

// Hands over work that reads or writes memory of the host's after its call has returned. Where it
// throws, what was handed over is waited for first: that memory may be gone when the caller knows.
template <typename Work>
decltype(auto) settled(const cl::CommandQueue& queue, Work&& work) {
  try {
    return work();
  } catch (...) {
    ::clFinish(queue());
    throw;
  }
}

}  // namespace cloudcontact::opencl
