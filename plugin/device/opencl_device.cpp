// Finds a device, builds its kernels and tests whether it computes the same bits as the CPU.
//
// By default OpenCL permits division and square root to be off by several bits, and a * b + c to be
// contracted. Both would change the contacts. The build options forbid them, lacking() checks that
// the device can comply, and test() checks that it does.
#include "device/opencl_device.h"

#include <cloudcontact/device/device_list.h>

#include "kernels/contact/batch_layout.h"
#include "kernels/cut/matter_cut.h"
#include "kernels/digitize/digitize_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <random>
#include <stdexcept>

namespace cloudcontact::opencl {

// Made by cmake/EmbedKernels.cmake.
extern const char* const kContactKernels;
extern const char* const kDigitizeKernels;
extern const char* const kCutKernels;

namespace {

constexpr char kOptions[] = "-cl-std=CL1.2 -cl-fp32-correctly-rounded-divide-sqrt";
constexpr char kPrelude[] =
    "#pragma OPENCL EXTENSION cl_khr_fp64 : enable\n#pragma OPENCL FP_CONTRACT OFF\n";
constexpr std::size_t kTests = 4096;  // operands of the self-test
constexpr std::size_t kLargestGroup = std::max({CC_GROUP, CC_SCAN_GROUP, CC_RENEW_GROUP});
constexpr std::size_t kNotes = 4096;  // events kept before they are summed

const char* sourceOf(Kernels kernels) {
  return kernels == Kernels::Contact    ? kContactKernels
         : kernels == Kernels::Digitize ? kDigitizeKernels
                                        : kCutKernels;
}

std::string describe(const cl::Error& e) {
  return std::string(e.what()) + " returned " + std::to_string(e.err());
}

// What a device lacks; empty if nothing.
std::string lacking(const cl::Device& device) {
  if (!device.getInfo<CL_DEVICE_AVAILABLE>() || !device.getInfo<CL_DEVICE_COMPILER_AVAILABLE>())
    return "has no compiler";
  if (device.getInfo<CL_DEVICE_PROFILE>() != "FULL_PROFILE") return "has no 64-bit integers";
  if (!device.getInfo<CL_DEVICE_ENDIAN_LITTLE>()) return "is big-endian";
  if (device.getInfo<CL_DEVICE_DOUBLE_FP_CONFIG>() == 0) return "has no doubles";
  if (const std::size_t largest = device.getInfo<CL_DEVICE_MAX_WORK_GROUP_SIZE>();
      largest < kLargestGroup)
    return "has work-groups of at most " + std::to_string(largest) + " work-items, not " +
           std::to_string(kLargestGroup);
  const cl_device_fp_config single = device.getInfo<CL_DEVICE_SINGLE_FP_CONFIG>();
  if (!(single & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT)) return "does not round divisions correctly";
  if (!(single & CL_FP_DENORM)) return "flushes denormal numbers to zero";
  return {};
}

// Its name, and what it lacks.
std::pair<std::string, std::string> nameAndFault(const cl::Device& device) {
  std::string name = "a device without a name";
  try {
    name = device.getInfo<CL_DEVICE_NAME>();
    return {name, lacking(device)};
  } catch (const cl::Error& e) {
    return {name, describe(e)};
  }
}

bool isGpu(const cl::Device& device) {
  return (device.getInfo<CL_DEVICE_TYPE>() & CL_DEVICE_TYPE_GPU) != 0;
}

// GPUs first.
std::vector<cl::Device> allDevices() {
  std::vector<cl::Platform> platforms;
  try {
    cl::Platform::get(&platforms);
  } catch (const cl::Error&) {  // the loader's way to report no platform
  }
  std::vector<cl::Device> devices;
  for (const cl::Platform& platform : platforms) {
    std::vector<cl::Device> some;
    try {
      platform.getDevices(CL_DEVICE_TYPE_ALL, &some);
    } catch (const cl::Error&) {
    }
    devices.insert(devices.end(), some.begin(), some.end());
  }
  std::stable_partition(devices.begin(), devices.end(), [](const cl::Device& device) {
    try {
      return isGpu(device);
    } catch (const cl::Error&) {  // open() reports it
      return false;
    }
  });
  return devices;
}

// Numbers of all magnitudes, and triples whose a b + c nearly cancels, so that contraction shows.
struct Operands {
  std::vector<float> a, b, c;

  Operands() {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> exponent(-30, 30), mantissa(1, 2);
    for (std::size_t i = 0; i < kTests; ++i) {
      const bool tiny = i % 8 == 7;  // products and quotients below 2^-126
      a.push_back(mantissa(random) * std::exp2(tiny ? -70.0f : std::round(exponent(random))));
      b.push_back(mantissa(random) * std::exp2(tiny ? -60.0f : std::round(exponent(random))));
      c.push_back(i % 2 ? -(a[i] * b[i]) * (1 + std::exp2(-20.0f)) : mantissa(random));
    }
  }
};

// Of ccSelfTest (kernels/base/self_test.cl): four operations on floats and three on doubles.
struct Results {
  std::vector<float> narrow = std::vector<float>(4 * kTests);
  std::vector<double> wide = std::vector<double>(3 * kTests);
};

Results expected(const Operands& t) {
  Results e;
  for (std::size_t i = 0, n = kTests; i < n; ++i) {
    const float x = t.a[i], y = t.b[i], z = t.c[i];
    e.narrow[i] = x / y;
    e.narrow[n + i] = std::sqrt(x);
    e.narrow[2 * n + i] = x * y + z;
    const float u = x * x - y * y, v = z * z;
    e.narrow[3 * n + i] = 1.0f / std::sqrt(u > v ? u : v);
    const double p = x, q = y, r = z;
    e.wide[i] = p / q;
    e.wide[n + i] = std::sqrt(p);
    e.wide[2 * n + i] = (p / 3.0) * (q / 7.0) + r / 11.0;
  }
  return e;
}

template <typename Number>
std::size_t differences(const std::vector<Number>& a, const std::vector<Number>& b,
                        std::size_t part) {
  std::size_t count = 0;
  for (std::size_t i = part * kTests; i < (part + 1) * kTests; ++i)
    count += std::memcmp(&a[i], &b[i], sizeof(Number)) != 0;
  return count;
}

// Adds a command's time; returns whether the command has ended. One that failed, or was never
// enqueued, adds nothing.
bool addTime(const cl::Event& event, const std::string& label,
             std::map<std::string, DeviceTime>& to) {
  if (!event()) return true;
  try {
    const cl_int status = event.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>();
    if (status > CL_COMPLETE) return false;
    if (status < CL_COMPLETE) return true;
    const double seconds =
        1e-9 * static_cast<double>(event.getProfilingInfo<CL_PROFILING_COMMAND_END>() -
                                   event.getProfilingInfo<CL_PROFILING_COMMAND_START>());
    DeviceTime& time = to[label];
    time.seconds += seconds;
    ++time.calls;
  } catch (const cl::Error&) {  // its time is unknown
  }
  return true;
}

// In the order of ccLayout() (kernels/contact/layout.cl).
constexpr std::array<cl_uint, 20> kLayout = {sizeof(CcField),
                                             sizeof(CcDirection),
                                             sizeof(CcPair),
                                             sizeof(CcFound),
                                             sizeof(CcAnswer),
                                             sizeof(CcBin),
                                             sizeof(CcSums),
                                             sizeof(CcSprout),
                                             offsetof(CcPair, enough),
                                             offsetof(CcDirection, nearby),
                                             offsetof(CcAnswer, firstPatch),
                                             offsetof(CcSums, deepest),
                                             sizeof(CcContactPatch),
                                             sizeof(CcPatchForce),
                                             offsetof(CcContactPatch, points),
                                             offsetof(CcPair, cell),
                                             sizeof(CcListed),
                                             sizeof(CcFacing),
                                             sizeof(CcPlaced),
                                             sizeof(CcShape)};

}  // namespace

std::runtime_error failure(const std::string& device, const cl::Error& e) {
  return std::runtime_error("OpenCL: " + device + " failed: " + describe(e));
}

std::shared_ptr<Device> Device::open(bool profiling, Kernels kernels) {
  std::string rejected;
  for (const cl::Device& device : allDevices()) {
    auto [name, why] = nameAndFault(device);
    try {
      if (why.empty())
        return std::shared_ptr<Device>(new Device(Hardware(device, profiling), kernels));
    } catch (const cl::Error& e) {
      why = describe(e);
    } catch (const std::runtime_error& e) {
      why = e.what();
    }
    rejected += "; " + name + " " + why;
  }
  if (rejected.empty())
    throw std::runtime_error(
        "no OpenCL device; install its driver (pocl-opencl-icd runs on any CPU), or use the CPU");
  throw std::runtime_error("no OpenCL device computes the same bits as the CPU" + rejected);
}

Device::Hardware::Hardware(const cl::Device& given, bool timed)
    : device(given),
      context(given),
      queue(context, given, timed ? CL_QUEUE_PROFILING_ENABLE : 0),
      name(given.getInfo<CL_DEVICE_NAME>()),
      memory(given.getInfo<CL_DEVICE_GLOBAL_MEM_SIZE>()),
      largest(given.getInfo<CL_DEVICE_MAX_MEM_ALLOC_SIZE>()),
      local(given.getInfo<CL_DEVICE_LOCAL_MEM_SIZE>()),
      gpu(isGpu(given)),
      profiling(timed) {}

std::shared_ptr<Device> Device::sharing(const Device& other, Kernels kernels) {
  return std::shared_ptr<Device>(new Device(other.hardware_, kernels));
}

Device::Device(const Hardware& hardware, Kernels kernels) : hardware_(hardware) {
  build(sourceOf(kernels));
  if (kernels == Kernels::Contact) checkLayout();
  test();
  clock();
}

void Device::build(const char* source) {
  program_ = cl::Program(context(), std::string(kPrelude) + source);
  try {
    const bool nvidia =
        hardware_.device.getInfo<CL_DEVICE_VENDOR>().find("NVIDIA") != std::string::npos;
    program_.build({hardware_.device},
                   (std::string(kOptions) + (nvidia ? " -DCC_NVIDIA" : "")).c_str());
  } catch (const cl::Error&) {
    std::string log = program_.getBuildInfo<CL_PROGRAM_BUILD_LOG>(hardware_.device);
    log.resize(std::min<std::size_t>(log.size(), 4000));
    throw std::runtime_error("cannot build the kernels: " + log);
  }
}

void Device::checkLayout() {
  std::array<cl_uint, kLayout.size()> got{};
  const cl::Buffer any(context(), CL_MEM_READ_WRITE, 4096),
      out(context(), CL_MEM_WRITE_ONLY, sizeof got);
  run({"ccLayout", 1, 1}, any, any, any, any, any, out);
  fetch(out, got.data(), sizeof got, "test");
  if (got != kLayout) throw std::runtime_error("lays out structures differently from the CPU");
}

void Device::test() {
  Operands operands;
  Results got;
  const auto input = [&](std::vector<float>& column) {
    return cl::Buffer(context(), CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, kTests * sizeof(float),
                      column.data());
  };
  const cl::Buffer a = input(operands.a), b = input(operands.b), c = input(operands.c);
  const cl::Buffer narrow(context(), CL_MEM_WRITE_ONLY, got.narrow.size() * sizeof(float)),
      wide(context(), CL_MEM_WRITE_ONLY, got.wide.size() * sizeof(double));
  run({"ccSelfTest", kTests, 64}, a, b, c, narrow, wide);
  fetch(narrow, got.narrow.data(), got.narrow.size() * sizeof(float), "test");
  fetch(wide, got.wide.data(), got.wide.size() * sizeof(double), "test");
  const Results want = expected(operands);
  const char* const operations[] = {"division", "square root", "product and sum",
                                    "root of a difference"};
  std::string wrong;
  const auto add = [&](const char* name, std::size_t count) {
    if (count > 0)
      wrong += std::string(wrong.empty() ? "" : ", ") + name + " (" + std::to_string(count) +
               " of " + std::to_string(kTests) + ")";
  };
  for (std::size_t part = 0; part < 4; ++part)
    add(operations[part], differences(got.narrow, want.narrow, part));
  for (std::size_t part = 0; part < 3; ++part)
    add("the same in double", differences(got.wide, want.wide, part));
  if (!wrong.empty()) throw std::runtime_error("rounds differently from the CPU: " + wrong);
}

cl::Kernel& Device::kernel(const std::string& name) {
  const auto known = kernels_.find(name);
  if (known != kernels_.end()) return known->second;
  return kernels_.emplace(name, cl::Kernel(program_, name.c_str())).first->second;
}

void Device::enqueue(cl::CommandQueue& queue, cl::Kernel& kernel, const Launch& launch) {
  if (launch.items == 0) return;
  const std::size_t all = (launch.items + launch.group - 1) / launch.group * launch.group;
  cl::Event* const noted = note(launch.label ? launch.label : launch.kernel);
  queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(all), cl::NDRange(launch.group),
                             nullptr, noted ? noted : launch.done);
  if (noted && launch.done) *launch.done = *noted;
}

cl::CommandQueue Device::newQueue() const {
  return {hardware_.context, hardware_.device,
          hardware_.profiling ? cl_command_queue_properties{CL_QUEUE_PROFILING_ENABLE} : 0};
}

void Device::send(const void* from, const cl::Buffer& to, std::size_t bytes, const char* label,
                  bool wait) {
  queue().enqueueWriteBuffer(to, wait ? CL_TRUE : CL_FALSE, 0, bytes, from, nullptr, note(label));
}

void Device::fetch(const cl::Buffer& from, void* to, std::size_t bytes, const char* label,
                   bool wait) {
  queue().enqueueReadBuffer(from, wait ? CL_TRUE : CL_FALSE, 0, bytes, to, nullptr, note(label));
}

cl::Event* Device::note(const char* label) {
  if (!hardware_.profiling) return nullptr;
  const std::lock_guard lock(notesMutex_);
  if (notes_.size() >= maxNotes_) sumNotes();
  notes_.push_back(std::make_unique<Note>(Note{label, std::this_thread::get_id(), {}}));
  return &notes_.back()->event;
}

// Sums the notes of ended commands, so that they do not pile up if nobody calls clock(). Only this
// thread's: another thread may be about to enqueue one.
void Device::sumNotes() {
  std::erase_if(notes_, [&](const std::unique_ptr<Note>& n) {
    return n->thread == std::this_thread::get_id() && addTime(n->event, n->label, summed_);
  });
  maxNotes_ = kNotes + 2 * notes_.size();
}

std::map<std::string, DeviceTime> Device::clock() {
  decltype(notes_) notes;
  std::map<std::string, DeviceTime> times;
  {
    const std::lock_guard lock(notesMutex_);
    notes.swap(notes_);
    times.swap(summed_);
  }
  guarded(name(), [&] { queue().finish(); });
  for (const auto& n : notes) addTime(n->event, n->label, times);
  return times;
}

// Unmaps first: PoCL keeps a mapped buffer for ever.
void PinnedMemory::release() {
  if (!data_) return;
  ::clEnqueueUnmapMemObject(queue_(), buffer_(), data_, 0, nullptr, nullptr);
  ::clFinish(queue_());
  buffer_ = cl::Buffer();
  data_ = nullptr;
  size_ = 0;
}

void* PinnedMemory::reserve(Device& device, std::size_t size) {
  if (size <= size_) return data_;
  release();  // first, because the allocation may throw
  const std::size_t larger = size + size / 4;
  queue_ = device.queue();
  buffer_ = cl::Buffer(device.context(), CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, larger);
  data_ = queue_.enqueueMapBuffer(buffer_, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, larger);
  size_ = larger;
  return data_;
}

const cl::Buffer& DeviceBuffer::reserve(Device& device, std::size_t size) {
  if (size > size_) {
    buffer_ = cl::Buffer();
    size_ = 0;  // first, because the allocation may throw
    const std::size_t larger = size + size / 4;
    if (larger > device.largestBuffer()) throw std::bad_alloc();
    buffer_ = cl::Buffer(device.context(), CL_MEM_READ_WRITE, larger);
    size_ = larger;
  }
  return buffer_;
}

const cl::Buffer& DeviceBuffer::clear(Device& device, std::size_t size) {
  device.queue().enqueueFillBuffer(reserve(device, size), cl_uint{0}, 0, size, nullptr,
                                   device.note("cleared"));
  return buffer_;
}

}  // namespace cloudcontact::opencl

std::vector<std::string> cloudcontact::openClDevices() {
  std::vector<std::string> names;
  for (const cl::Device& device : opencl::allDevices()) {
    const auto [name, why] = opencl::nameAndFault(device);
    names.push_back(why.empty() ? name : name + " (" + why + ")");
  }
  return names;
}
