// OpenCL behind one interface: a device that computes the same bits as the CPU, its kernels, its
// memory and its errors. OpenCL's headers are included only here.
#pragma once

#define CL_HPP_TARGET_OPENCL_VERSION 120
#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#define CL_HPP_ENABLE_EXCEPTIONS
#include <cloudcontact/device/backend.h>
#include <CL/opencl.hpp>

#include <algorithm>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace cloudcontact::opencl {

// The programs that a device can build. Each takes its compiler some time.
enum class Kernels { Contact, Digitize, Cut };

// One run of a kernel over so many work-items in groups.
struct Launch {
  const char* kernel;
  std::size_t items, group;
  const char* label = nullptr;  // in clock(), if not the kernel's name
  cl::Event* done = nullptr;    // set to the run's event
};

class Device {
 public:
  // The first device that passes the self-test, GPUs first. Throws std::runtime_error that lists
  // every rejected device and why, or says that there is none. With `profiling` the queue times its
  // commands, which costs time.
  static std::shared_ptr<Device> open(bool profiling = false, Kernels kernels = Kernels::Contact);
  // Of all devices, as openClDevices() gives them.
  static std::vector<std::string> names();
  // The same device, context and queue with other kernels.
  static std::shared_ptr<Device> sharing(const Device& other, Kernels kernels);

  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const std::string& name() const { return hardware_.name; }
  cl::Context& context() { return hardware_.context; }
  cl::CommandQueue& queue() { return hardware_.queue; }
  std::size_t memory() const { return hardware_.memory; }          // [bytes]
  std::size_t largestBuffer() const { return hardware_.largest; }  // [bytes]
  std::size_t localBytes() const { return hardware_.local; }       // local memory of a work-group
  bool gpu() const { return hardware_.gpu; }

  // Sets all arguments of a kernel and enqueues it.
  template <typename... Arguments>
  void run(const Launch& launch, const Arguments&... arguments) {
    cl::Kernel& called = kernel(launch.kernel);
    cl_uint k = 0;
    (called.setArg(k++, arguments), ...);
    enqueue(queue(), called, launch);
  }
  // Enqueues a kernel whose arguments are set.
  void enqueue(cl::CommandQueue& queue, cl::Kernel& kernel, const Launch& launch);
  // A queue whose commands may run beside those of queue(), and a kernel with its own arguments.
  cl::CommandQueue newQueue() const;
  cl::Kernel newKernel(const char* name) const { return {program_, name}; }

  // Copies on queue(), which clock() reports under `label`. Without `wait` the host's memory must
  // stay until the copy is done.
  void send(const void* from, const cl::Buffer& to, std::size_t bytes, const char* label,
            bool wait = false);
  void fetch(const cl::Buffer& from, void* to, std::size_t bytes, const char* label,
             bool wait = true);
  // An event for a copy that clock() reports under `label`; null without profiling.
  cl::Event* note(const char* label);
  // Time of each kernel and copy since the last call. Waits for queue(); commands of other queues
  // must have ended. Throws std::runtime_error if the device fails.
  std::map<std::string, DeviceTime> clock();

 private:
  // A device with its context and queue.
  struct Hardware {
    cl::Device device;
    cl::Context context;
    cl::CommandQueue queue;
    std::string name;
    std::size_t memory = 0, largest = 0, local = 0;
    bool gpu = false, profiling = false;

    Hardware(const cl::Device& device, bool profiling);
  };
  Device(const Hardware& hardware, Kernels kernels);
  void build(const char* source);
  cl::Kernel& kernel(const std::string& name);
  void checkLayout();
  void test();

  struct Note {
    std::string label;
    std::thread::id thread;
    cl::Event event;
  };
  void sumNotes();

  Hardware hardware_;
  cl::Program program_;
  std::map<std::string, cl::Kernel, std::less<>> kernels_;
  std::mutex notesMutex_;
  std::vector<std::unique_ptr<Note>> notes_;
  std::size_t maxNotes_ = 0;
  std::map<std::string, DeviceTime> summed_;  // of notes that are no longer kept
};

// Host memory that the device copies at full speed.
class PinnedMemory {
 public:
  PinnedMemory() = default;
  ~PinnedMemory() { release(); }
  PinnedMemory(const PinnedMemory&) = delete;
  PinnedMemory& operator=(const PinnedMemory&) = delete;

  // At least `size` bytes. Growing discards the content.
  void* reserve(Device& device, std::size_t size);
  void* data() const { return data_; }
  void release();

 private:
  cl::CommandQueue queue_;  // that maps the buffer
  cl::Buffer buffer_;
  void* data_ = nullptr;
  std::size_t size_ = 0;
};

// A device buffer that grows and never shrinks. Growing discards the content; throws std::bad_alloc
// beyond the device's largest buffer.
class DeviceBuffer {
 public:
  const cl::Buffer& reserve(Device& device, std::size_t size);
  // With that content; kernels need a buffer even if it is empty. `wait` as in Device::send().
  template <typename Values>
  const cl::Buffer& fill(Device& device, const Values& values, const char* label,
                         bool wait = false) {
    const std::size_t bytes = values.size() * sizeof(values[0]);
    reserve(device, std::max<std::size_t>(bytes, 16));
    if (bytes > 0) device.send(values.data(), buffer_, bytes, label, wait);
    return buffer_;
  }
  // All bits 0.
  const cl::Buffer& clear(Device& device, std::size_t size);
  const cl::Buffer& buffer() const { return buffer_; }
  std::size_t bytes() const { return size_; }

 private:
  cl::Buffer buffer_;
  std::size_t size_ = 0;
};

// OpenCL's errors are not std::runtime_errors, so none may leave this room.
std::runtime_error failure(const std::string& device, const cl::Error& e);

// Turns an OpenCL error into a std::runtime_error that names the device and the call.
template <typename Work>
decltype(auto) guarded(const std::string& device, Work&& work) {
  try {
    return work();
  } catch (const cl::Error& e) {
    throw failure(device, e);
  }
}

// The same for work that the CPU can do instead: std::bad_alloc if the device is out of memory.
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

// For work that enqueues asynchronous transfers: waits for them before an exception leaves, because
// the caller may then free the host memory.
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
