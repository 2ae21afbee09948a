// Makes OpenCL calls fail. A test program that includes this replaces some of OpenCL's functions;
// they call the original unless a Fault is in scope. Include it in one source file of a program.
#pragma once

#include <dlfcn.h>

#include <atomic>
#include <cstring>
#include <map>
#include <string_view>

#include "device/opencl_device.h"

namespace cloudcontact::test {

struct OpenClCalls {
  std::string_view failing;                       // name of the call that fails
  std::atomic<int> remaining{0};                  // calls of it that still succeed
  std::size_t maxBytes = ~std::size_t{0};         // of a buffer
  std::map<cl_device_info, std::uint64_t> faked;  // device properties
  // Whether the device may still read or write host memory.
  std::atomic<bool> pending{false};
  std::atomic<int> eventsReleased{0};

  bool fails(std::string_view name) { return name == failing && remaining-- <= 0; }
};
inline OpenClCalls calls;

// While in scope, one call fails, once it has succeeded `after` times.
class Fault {
 public:
  explicit Fault(std::string_view name, int after = 0) {
    calls.failing = name;
    calls.remaining = after;
  }
  ~Fault() { calls.failing = {}; }
  Fault(const Fault&) = delete;
  Fault& operator=(const Fault&) = delete;
};

// While in scope, larger buffers cannot be allocated.
class LittleMemory {
 public:
  explicit LittleMemory(std::size_t maxBytes) { calls.maxBytes = maxBytes; }
  ~LittleMemory() { calls.maxBytes = ~std::size_t{0}; }
  LittleMemory(const LittleMemory&) = delete;
  LittleMemory& operator=(const LittleMemory&) = delete;
};

// While in scope, all devices report this value for a property.
class FakeInfo {
 public:
  FakeInfo(cl_device_info property, std::uint64_t value) : property_(property) {
    calls.faked[property] = value;
  }
  ~FakeInfo() { calls.faked.erase(property_); }
  FakeInfo(const FakeInfo&) = delete;
  FakeInfo& operator=(const FakeInfo&) = delete;

 private:
  cl_device_info property_;
};

template <typename Call>
Call* original(const char* name, Call*) {
  return reinterpret_cast<Call*>(::dlsym(RTLD_NEXT, name));
}
#define CC_ORIGINAL(name) cloudcontact::test::original(#name, &name)

// A read or a write. One that does not block is pending until clFinish().
template <typename Call, typename... Arguments>
cl_int transfer(std::string_view name, Call* call, cl_bool blocking, Arguments... arguments) {
  if (calls.fails(name)) return CL_INVALID_OPERATION;
  const cl_int result = call(arguments...);
  calls.pending = !blocking;
  return result;
}

}  // namespace cloudcontact::test

extern "C" {

cl_mem clCreateBuffer(cl_context context, cl_mem_flags flags, size_t size, void* host,
                      cl_int* error) {
  static auto* const call = CC_ORIGINAL(clCreateBuffer);
  if (size <= cloudcontact::test::calls.maxBytes) return call(context, flags, size, host, error);
  if (error) *error = CL_MEM_OBJECT_ALLOCATION_FAILURE;
  return nullptr;
}

cl_int clEnqueueReadBuffer(cl_command_queue queue, cl_mem from, cl_bool blocking, size_t offset,
                           size_t size, void* to, cl_uint count, const cl_event* list,
                           cl_event* event) {
  static auto* const call = CC_ORIGINAL(clEnqueueReadBuffer);
  return cloudcontact::test::transfer("clEnqueueReadBuffer", call, blocking, queue, from, blocking,
                                      offset, size, to, count, list, event);
}

cl_int clEnqueueWriteBuffer(cl_command_queue queue, cl_mem to, cl_bool blocking, size_t offset,
                            size_t size, const void* from, cl_uint count, const cl_event* list,
                            cl_event* event) {
  static auto* const call = CC_ORIGINAL(clEnqueueWriteBuffer);
  return cloudcontact::test::transfer("clEnqueueWriteBuffer", call, blocking, queue, to, blocking,
                                      offset, size, from, count, list, event);
}

cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions,
                              const size_t* begin, const size_t* all, const size_t* group,
                              cl_uint count, const cl_event* list, cl_event* event) {
  static auto* const call = CC_ORIGINAL(clEnqueueNDRangeKernel);
  if (cloudcontact::test::calls.fails("clEnqueueNDRangeKernel")) return CL_INVALID_OPERATION;
  return call(queue, kernel, dimensions, begin, all, group, count, list, event);
}

cl_int clFinish(cl_command_queue queue) {
  static auto* const call = CC_ORIGINAL(clFinish);
  const cl_int result = call(queue);
  cloudcontact::test::calls.pending = false;
  return cloudcontact::test::calls.fails("clFinish") ? CL_INVALID_OPERATION : result;
}

cl_int clReleaseEvent(cl_event event) {
  static auto* const call = CC_ORIGINAL(clReleaseEvent);
  ++cloudcontact::test::calls.eventsReleased;
  return call(event);
}

cl_int clGetDeviceInfo(cl_device_id device, cl_device_info property, size_t room, void* to,
                       size_t* size) {
  static auto* const call = CC_ORIGINAL(clGetDeviceInfo);
  cloudcontact::test::OpenClCalls& calls = cloudcontact::test::calls;
  if (property == CL_DEVICE_NAME && calls.fails("its name")) return CL_INVALID_OPERATION;
  if (property == CL_DEVICE_TYPE && calls.fails("its type")) return CL_INVALID_OPERATION;
  const cl_int result = call(device, property, room, to, size);
  const auto fake = calls.faked.find(property);
  if (to && fake != calls.faked.end()) std::memcpy(to, &fake->second, sizeof fake->second);
  return result;
}

}  // extern "C"
