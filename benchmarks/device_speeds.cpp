// Each speed is the best of several tries, by the device's clock where possible.
#include "device_speeds.h"

#include "device/opencl_device.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <string>

namespace cloudcontact {

namespace {

using opencl::Device;

constexpr int kTries = 8;

// Memory bandwidth, gathers, double arithmetic, and nothing.
constexpr char kKernels[] = R"(
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#pragma OPENCL FP_CONTRACT OFF
__kernel void ccCopy(__global const float4* from, __global float4* to) {
  to[get_global_id(0)] = from[get_global_id(0)];
}

__kernel void ccGather(__global const uint2* records, uint mask, __global uint* out) {
  uint k = (uint)get_global_id(0) * 2654435761u, sum = 0;
  for (int i = 0; i < 16; ++i) {
    k = k * 1664525u + 1013904223u;
    const uint2 r = records[(k >> 7) & mask];
    sum += r.x + r.y;
  }
  out[get_global_id(0)] = sum;
}

__kernel void ccDoubles(double factor, __global double* out) {
  double a = (double)get_global_id(0), b = a + 1.0, c = a + 2.0, d = a + 3.0;
  for (int i = 0; i < 256; ++i) {
    a = a * factor + 1.0;
    b = b * factor + 1.0;
    c = c * factor + 1.0;
    d = d * factor + 1.0;
  }
  out[get_global_id(0)] = a + b + c + d;
}

__kernel void ccNothing(__global uint* out) {
  if (get_global_id(0) == 0) out[0] = 0u;
}
)";

class Probe {
 public:
  explicit Probe(Device& device)
      : device_(device),
        a_(device.context(), CL_MEM_READ_WRITE, kBytes),
        b_(device.context(), CL_MEM_READ_WRITE, kBytes),
        program_(device.context(), std::string(kKernels)) {
    program_.build("-cl-std=CL1.2");
    device.queue().enqueueFillBuffer(a_, cl_uint{1}, 0, kBytes);
  }

  double copy() { return 2.0 * kBytes / best("ccCopy", kBytes / 16, a_, b_); }
  double gather() {
    constexpr std::size_t kItems = 1 << 20;
    return 16.0 * kItems / best("ccGather", kItems, a_, cl_uint{(1u << 21) - 1}, b_);
  }
  double doubles() {
    constexpr std::size_t kItems = 1 << 20;
    return 2.0 * 4 * 256 * kItems / best("ccDoubles", kItems, 0.999, b_);
  }
  double transfer(bool up) {
    constexpr std::size_t kPart = std::size_t{8} << 20;
    opencl::PinnedMemory host;
    void* const data = host.reserve(device_, kPart);
    device_.clock();
    double least = 1e300;
    for (int i = 0; i < kTries; ++i) {
      cl::Event* const event = device_.note("transfer");
      if (up)
        device_.queue().enqueueWriteBuffer(a_, CL_FALSE, 0, kPart, data, nullptr, event);
      else
        device_.queue().enqueueReadBuffer(a_, CL_FALSE, 0, kPart, data, nullptr, event);
      least = std::min(least, device_.clock()["transfer"].seconds);
    }
    return kPart / std::max(least, 1e-12);
  }
  double launch() {
    double least = 1e300;
    for (int i = 0; i < kTries; ++i) {
      const auto begin = std::chrono::steady_clock::now();
      run({"ccNothing", 64, 64}, b_);
      device_.queue().finish();
      least = std::min(
          least, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    }
    device_.clock();
    return least;
  }

 private:
  static constexpr std::size_t kBytes = std::size_t{128} << 20;

  template <typename... Arguments>
  void run(const opencl::Launch& launch, const Arguments&... arguments) {
    cl::Kernel& kernel = kernels_[launch.kernel];
    if (!kernel()) kernel = cl::Kernel(program_, launch.kernel);
    cl_uint k = 0;
    (kernel.setArg(k++, arguments), ...);
    device_.enqueue(device_.queue(), kernel, launch);
  }
  template <typename... Arguments>
  double best(const char* name, std::size_t items, const Arguments&... arguments) {
    device_.clock();
    double least = 1e300;
    for (int i = 0; i < kTries; ++i) {
      run({name, items, 128}, arguments...);
      least = std::min(least, device_.clock()[name].seconds);
    }
    return std::max(least, 1e-12);
  }

  Device& device_;
  cl::Buffer a_, b_;
  cl::Program program_;
  std::map<std::string, cl::Kernel> kernels_;
};

}  // namespace

DeviceSpeeds measureDevice() {
  const std::shared_ptr<Device> device = Device::open(true);
  Probe probe(*device);
  return {device->name(),       probe.copy(),          probe.gather(), probe.doubles(),
          probe.transfer(true), probe.transfer(false), probe.launch()};
}

}  // namespace cloudcontact
