// Each speed is the best of several tries, by the device's clock where possible.
#include "device/device_speeds.h"

#include "device/opencl_device.h"

#include <algorithm>
#include <chrono>

namespace cloudcontact {

namespace {

using opencl::Device;

constexpr int kTries = 8;

class Probe {
 public:
  explicit Probe(Device& device)
      : device_(device),
        a_(device.context(), CL_MEM_READ_WRITE, kBytes),
        b_(device.context(), CL_MEM_READ_WRITE, kBytes) {
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
      device_.run({"ccNothing", 64, 64}, b_);
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
  double best(const char* name, std::size_t items, const Arguments&... arguments) {
    device_.clock();
    double least = 1e300;
    for (int i = 0; i < kTries; ++i) {
      device_.run({name, items, 128}, arguments...);
      least = std::min(least, device_.clock()[name].seconds);
    }
    return std::max(least, 1e-12);
  }

  Device& device_;
  cl::Buffer a_, b_;
};

}  // namespace

DeviceSpeeds measureDevice() {
  const std::shared_ptr<Device> device = Device::open(true);
  Probe probe(*device);
  return {device->name(),       probe.copy(),          probe.gather(), probe.doubles(),
          probe.transfer(true), probe.transfer(false), probe.launch()};
}

}  // namespace cloudcontact
