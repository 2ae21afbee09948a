// Finding a device, building the kernels for it, and finding out whether it computes as the CPU.
//
// OpenCL lets a device round division and root by several bits and contract a * b + c unless told
// otherwise; a device that does so gives other contacts. It is told otherwise, asked whether it
// can, and then tried.
#include "device/opencl_device.h"

#include "device/device_guard.h"
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
constexpr std::size_t kTests = 4096;
constexpr std::size_t kLargestGroup = std::max({CC_GROUP, CC_SCAN_GROUP, CC_RENEW_GROUP});
constexpr std::size_t kNotes = 4096;  // of what commands took, that are kept

const char* sourceOf(Kernels kernels) {
  return kernels == Kernels::Contact    ? kContactKernels
         : kernels == Kernels::Digitize ? kDigitizeKernels
                                        : kCutKernels;
}

std::string said(const cl::Error& e) {
  return std::string(e.what()) + " gave " + std::to_string(e.err());
}

// Why a device cannot be meant for this work; empty where it may.
std::string lacking(const cl::Device& device) {
  if (!device.getInfo<CL_DEVICE_AVAILABLE>() || !device.getInfo<CL_DEVICE_COMPILER_AVAILABLE>())
    return "has no compiler";
  if (device.getInfo<CL_DEVICE_PROFILE>() != "FULL_PROFILE") return "knows no 64-bit integers";
  if (!device.getInfo<CL_DEVICE_ENDIAN_LITTLE>()) return "is big-endian";
  if (device.getInfo<CL_DEVICE_DOUBLE_FP_CONFIG>() == 0) return "knows no doubles";
  if (const std::size_t most = device.getInfo<CL_DEVICE_MAX_WORK_GROUP_SIZE>();
      most < kLargestGroup)
    return "lets " + std::to_string(most) + " work-items work together at most, not " +
           std::to_string(kLargestGroup);
  const cl_device_fp_config single = device.getInfo<CL_DEVICE_SINGLE_FP_CONFIG>();
  if (!(single & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT)) return "does not round divisions correctly";
  if (!(single & CL_FP_DENORM)) return "drops numbers below the normal ones";
  return {};
}

bool isGpu(const cl::Device& device) {
  return (device.getInfo<CL_DEVICE_TYPE>() & CL_DEVICE_TYPE_GPU) != 0;
}

// GPUs before others.
std::vector<cl::Device> allDevices() {
  std::vector<cl::Platform> platforms;
  try {
    cl::Platform::get(&platforms);
  } catch (const cl::Error&) {  // the loader's way to say that there is none
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
    } catch (const cl::Error&) {  // says so again when it is asked more
      return false;
    }
  });
  return devices;
}

// Numbers of all sizes, and triples of which x y + z cancels, so that contraction shows.
struct Trial {
  std::vector<float> a, b, c;

  Trial() {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> size(-30, 30), mantissa(1, 2);
    for (std::size_t i = 0; i < kTests; ++i) {
      const bool tiny = i % 8 == 7;  // products and quotients below 2^-126
      a.push_back(mantissa(random) * std::exp2(tiny ? -70.0f : std::round(size(random))));
      b.push_back(mantissa(random) * std::exp2(tiny ? -60.0f : std::round(size(random))));
      c.push_back(i % 2 ? -(a[i] * b[i]) * (1 + std::exp2(-20.0f)) : mantissa(random));
    }
  }
};

struct Answers {
  std::vector<float> narrow = std::vector<float>(4 * kTests);
  std::vector<double> wide = std::vector<double>(3 * kTests);
};

Answers expected(const Trial& t) {
  Answers e;
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
std::size_t unlike(const std::vector<Number>& a, const std::vector<Number>& b, std::size_t part) {
  std::size_t count = 0;
  for (std::size_t i = part * kTests; i < (part + 1) * kTests; ++i)
    count += std::memcmp(&a[i], &b[i], sizeof(Number)) != 0;
  return count;
}

// Adds what a command took; whether it has come to its end. One that failed, or was never handed
// over, took nothing.
bool added(const cl::Event& event, const std::string& name, std::map<std::string, Spent>& to) {
  if (!event()) return true;
  try {
    const cl_int status = event.getInfo<CL_EVENT_COMMAND_EXECUTION_STATUS>();
    if (status > CL_COMPLETE) return false;
    if (status < CL_COMPLETE) return true;
    const double seconds =
        1e-9 * static_cast<double>(event.getProfilingInfo<CL_PROFILING_COMMAND_END>() -
                                   event.getProfilingInfo<CL_PROFILING_COMMAND_START>());
    Spent& s = to[name];
    s.seconds += seconds;
    ++s.calls;
  } catch (const cl::Error&) {  // nobody knows what it took
  }
  return true;
}

// As ccLayout() of kernels/layout.cl has them.
constexpr std::array<cl_uint, 16> kLayout = {sizeof(CcField),
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
                                             offsetof(CcPair, cell)};

}  // namespace

std::shared_ptr<Device> Device::open(bool profiling, Kernels kernels) {
  std::string refused;
  for (const cl::Device& device : allDevices()) {
    std::string name = "a device without a name", why;
    try {
      name = device.getInfo<CL_DEVICE_NAME>();
      why = lacking(device);
      if (why.empty()) return std::shared_ptr<Device>(new Device(device, profiling, kernels));
    } catch (const cl::Error& e) {
      why = said(e);
    } catch (const std::runtime_error& e) {
      why = e.what();
    }
    refused += "; " + name + " " + why;
  }
  if (refused.empty())
    throw std::runtime_error(
        "no OpenCL device; install its driver (pocl-opencl-icd runs on any CPU), or take the CPU");
  throw std::runtime_error("no OpenCL device that computes as the CPU does" + refused);
}

Device::Device(const cl::Device& device, bool profiling, Kernels kernels)
    : device_(device),
      context_(device),
      queue_(context_, device, profiling ? CL_QUEUE_PROFILING_ENABLE : 0),
      name_(device.getInfo<CL_DEVICE_NAME>()),
      memory_(device.getInfo<CL_DEVICE_GLOBAL_MEM_SIZE>()),
      largest_(device.getInfo<CL_DEVICE_MAX_MEM_ALLOC_SIZE>()),
      local_(device.getInfo<CL_DEVICE_LOCAL_MEM_SIZE>()),
      gpu_(isGpu(device)),
      profiling_(profiling) {
  begin(kernels);
}

Device::Device(const Device& other, Kernels kernels)
    : device_(other.device_),
      context_(other.context_),
      queue_(other.queue_),
      name_(other.name_),
      memory_(other.memory_),
      largest_(other.largest_),
      local_(other.local_),
      gpu_(other.gpu_),
      profiling_(other.profiling_) {
  begin(kernels);
}

std::shared_ptr<Device> Device::beside(const Device& other, Kernels kernels) {
  return std::shared_ptr<Device>(new Device(other, kernels));
}

void Device::begin(Kernels kernels) {
  build(sourceOf(kernels));
  if (kernels == Kernels::Contact) checkLayout();
  test();
  clock();
}

void Device::build(const char* source) {
  program_ = cl::Program(context_, std::string(kPrelude) + source);
  try {
    const bool nvidia = device_.getInfo<CL_DEVICE_VENDOR>().find("NVIDIA") != std::string::npos;
    program_.build({device_}, (std::string(kOptions) + (nvidia ? " -DCC_NVIDIA" : "")).c_str());
  } catch (const cl::Error&) {
    std::string log = program_.getBuildInfo<CL_PROGRAM_BUILD_LOG>(device_);
    log.resize(std::min<std::size_t>(log.size(), 4000));
    throw std::runtime_error("does not build the kernels: " + log);
  }
}

void Device::checkLayout() {
  std::array<cl_uint, kLayout.size()> got{};
  const cl::Buffer any(context_, CL_MEM_READ_WRITE, 4096),
      out(context_, CL_MEM_WRITE_ONLY, sizeof got);
  cl::Kernel& asked = kernel("ccLayout");
  for (cl_uint k = 0; k < 5; ++k) asked.setArg(k, any);
  asked.setArg(5, out);
  run("ccLayout", 1, 1);
  queue_.enqueueReadBuffer(out, CL_TRUE, 0, sizeof got, got.data());
  if (got != kLayout) throw std::runtime_error("lays structures out otherwise than the CPU");
}

void Device::test() {
  Trial trial;
  Answers got;
  cl::Buffer in[3];
  int argument = 0;
  cl::Kernel& tester = kernel("ccSelfTest");
  for (auto* column : {&trial.a, &trial.b, &trial.c}) {
    in[argument] = cl::Buffer(context_, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR,
                              kTests * sizeof(float), column->data());
    tester.setArg(static_cast<cl_uint>(argument), in[argument]);
    ++argument;
  }
  const cl::Buffer narrow(context_, CL_MEM_WRITE_ONLY, got.narrow.size() * sizeof(float)),
      wide(context_, CL_MEM_WRITE_ONLY, got.wide.size() * sizeof(double));
  tester.setArg(3, narrow);
  tester.setArg(4, wide);
  run("ccSelfTest", kTests, 64);
  queue_.enqueueReadBuffer(narrow, CL_TRUE, 0, got.narrow.size() * sizeof(float),
                           got.narrow.data());
  queue_.enqueueReadBuffer(wide, CL_TRUE, 0, got.wide.size() * sizeof(double), got.wide.data());
  const Answers want = expected(trial);
  const char* const what[] = {"division", "root", "product and sum", "root of a difference"};
  std::string wrong;
  const auto tell = [&](const char* name, std::size_t count) {
    if (count > 0)
      wrong += std::string(wrong.empty() ? "" : ", ") + name + " (" + std::to_string(count) +
               " of " + std::to_string(kTests) + ")";
  };
  for (std::size_t part = 0; part < 4; ++part)
    tell(what[part], unlike(got.narrow, want.narrow, part));
  for (std::size_t part = 0; part < 3; ++part)
    tell("the same in double", unlike(got.wide, want.wide, part));
  if (!wrong.empty()) throw std::runtime_error("rounds otherwise than the CPU: " + wrong);
}

cl::Kernel& Device::kernel(const std::string& name) {
  const auto known = kernels_.find(name);
  if (known != kernels_.end()) return known->second;
  return kernels_.emplace(name, cl::Kernel(program_, name.c_str())).first->second;
}

void Device::run(const char* name, std::size_t items, std::size_t group) {
  run(kernel(name), name, items, group);
}

void Device::run(cl::Kernel& kernel, const char* name, std::size_t items, std::size_t group) {
  run(queue_, kernel, name, items, group);
}

void Device::run(cl::CommandQueue& queue, cl::Kernel& kernel, const char* name, std::size_t items,
                 std::size_t group, cl::Event* done) {
  if (items == 0) return;
  const std::size_t all = (items + group - 1) / group * group;
  cl::Event* const noted = note(name);
  queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(all), cl::NDRange(group), nullptr,
                             noted ? noted : done);
  if (noted && done) *done = *noted;
}

cl::CommandQueue Device::another() {
  return {context_, device_,
          profiling_ ? cl_command_queue_properties{CL_QUEUE_PROFILING_ENABLE} : 0};
}

cl::Event* Device::note(const char* name) {
  if (!profiling_) return nullptr;
  const std::lock_guard lock(noting_);
  if (notes_.size() >= mostNotes_) sumUp();
  notes_.push_back(std::make_unique<Noted>(Noted{name, std::this_thread::get_id(), {}}));
  return &notes_.back()->event;
}

// Sums up notes of what has ended, so that they do not grow without end where nobody asks. This
// thread's alone: another may be about to hand one over.
void Device::sumUp() {
  std::erase_if(notes_, [&](const std::unique_ptr<Noted>& n) {
    return n->by == std::this_thread::get_id() && added(n->event, n->name, summed_);
  });
  mostNotes_ = kNotes + 2 * notes_.size();
}

std::map<std::string, Spent> Device::clock() {
  decltype(notes_) notes;
  std::map<std::string, Spent> spent;
  {
    const std::lock_guard lock(noting_);
    notes.swap(notes_);
    spent.swap(summed_);
  }
  guarded(name_, [&] { queue_.finish(); });
  for (const auto& n : notes) added(n->event, n->name, spent);
  return spent;
}

}  // namespace cloudcontact::opencl
