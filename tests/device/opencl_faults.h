// OpenCL's calls as a test wants them to fail. A program that includes this has its own of some of
// them, which the library's then are: they go on to OpenCL's unless a Fault lasts. For one source
// file of a program.
#pragma once

#include <dlfcn.h>

#include <atomic>
#include <cstring>
#include <map>
#include <string_view>

#include "device/opencl.h"

namespace cloudcontact::test {

struct OpenClCalls {
  std::string_view failing;                      // the name of the call that fails
  std::atomic<int> until{0};                     // calls of it that do not, yet
  std::size_t mostBytes = ~std::size_t{0};       // that a buffer may have
  std::map<cl_device_info, std::uint64_t> said;  // of every device, in place of the truth
  // Whether the device may still read or write memory of the host's.
  std::atomic<bool> underWay{false};
  std::atomic<int> eventsReleased{0};

  bool fails(std::string_view name) { return name == failing && until-- <= 0; }
};
inline OpenClCalls calls;

// While it lasts, a call fails, `after` so many that do not.
class Fault {
 public:
  explicit Fault(std::string_view name, int after = 0) {
    calls.failing = name;
    calls.until = after;
  }
  ~Fault() { calls.failing = {}; }
  Fault(const Fault&) = delete;
  Fault& operator=(const Fault&) = delete;
};

// While it lasts, there is no room for buffers of more bytes.
class LittleMemory {
 public:
  explicit LittleMemory(std::size_t mostBytes) { calls.mostBytes = mostBytes; }
  ~LittleMemory() { calls.mostBytes = ~std::size_t{0}; }
  LittleMemory(const LittleMemory&) = delete;
  LittleMemory& operator=(const LittleMemory&) = delete;
};

// While it lasts, devices say this of themselves.
class Said {
 public:
  Said(cl_device_info what, std::uint64_t value) : what_(what) { calls.said[what] = value; }
  ~Said() { calls.said.erase(what_); }
  Said(const Said&) = delete;
  Said& operator=(const Said&) = delete;

 private:
  cl_device_info what_;
};

template <typename Call>
Call* openCls(const char* name, Call*) {
  return reinterpret_cast<Call*>(::dlsym(RTLD_NEXT, name));
}
#define CC_OPENCLS(name) cloudcontact::test::openCls(#name, &name)

}  // namespace cloudcontact::test

extern "C" {

cl_mem clCreateBuffer(cl_context context, cl_mem_flags flags, size_t size, void* host,
                      cl_int* error) {
  static auto* const call = CC_OPENCLS(clCreateBuffer);
  if (size <= cloudcontact::test::calls.mostBytes) return call(context, flags, size, host, error);
  if (error) *error = CL_MEM_OBJECT_ALLOCATION_FAILURE;
  return nullptr;
}

cl_int clEnqueueReadBuffer(cl_command_queue queue, cl_mem from, cl_bool waits, size_t offset,
                           size_t size, void* to, cl_uint count, const cl_event* list,
                           cl_event* event) {
  static auto* const call = CC_OPENCLS(clEnqueueReadBuffer);
  cloudcontact::test::OpenClCalls& calls = cloudcontact::test::calls;
  if (calls.fails("clEnqueueReadBuffer")) return CL_INVALID_OPERATION;
  const cl_int result = call(queue, from, waits, offset, size, to, count, list, event);
  calls.underWay = !waits;
  return result;
}

cl_int clEnqueueWriteBuffer(cl_command_queue queue, cl_mem to, cl_bool waits, size_t offset,
                            size_t size, const void* from, cl_uint count, const cl_event* list,
                            cl_event* event) {
  static auto* const call = CC_OPENCLS(clEnqueueWriteBuffer);
  cloudcontact::test::OpenClCalls& calls = cloudcontact::test::calls;
  if (calls.fails("clEnqueueWriteBuffer")) return CL_INVALID_OPERATION;
  const cl_int result = call(queue, to, waits, offset, size, from, count, list, event);
  calls.underWay = !waits;
  return result;
}

cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions,
                              const size_t* begin, const size_t* all, const size_t* group,
                              cl_uint count, const cl_event* list, cl_event* event) {
  static auto* const call = CC_OPENCLS(clEnqueueNDRangeKernel);
  if (cloudcontact::test::calls.fails("clEnqueueNDRangeKernel")) return CL_INVALID_OPERATION;
  return call(queue, kernel, dimensions, begin, all, group, count, list, event);
}

cl_int clFinish(cl_command_queue queue) {
  static auto* const call = CC_OPENCLS(clFinish);
  const cl_int result = call(queue);
  cloudcontact::test::calls.underWay = false;
  return cloudcontact::test::calls.fails("clFinish") ? CL_INVALID_OPERATION : result;
}

cl_int clReleaseEvent(cl_event event) {
  static auto* const call = CC_OPENCLS(clReleaseEvent);
  ++cloudcontact::test::calls.eventsReleased;
  return call(event);
}

cl_int clGetDeviceInfo(cl_device_id device, cl_device_info what, size_t room, void* to,
                       size_t* size) {
  static auto* const call = CC_OPENCLS(clGetDeviceInfo);
  cloudcontact::test::OpenClCalls& calls = cloudcontact::test::calls;
  if (what == CL_DEVICE_NAME && calls.fails("its name")) return CL_INVALID_OPERATION;
  if (what == CL_DEVICE_TYPE && calls.fails("its type")) return CL_INVALID_OPERATION;
  const cl_int result = call(device, what, room, to, size);
  const auto other = calls.said.find(what);
  if (to && other != calls.said.end()) std::memcpy(to, &other->second, sizeof other->second);
  return result;
}

}  // extern "C"
