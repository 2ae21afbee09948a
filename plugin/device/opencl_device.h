// An OpenCL device that computes as the CPU does, to the bit, with the kernels built for it.
#pragma once

#include "device/opencl.h"

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace cloudcontact::opencl {

// What a kernel or a copy took, summed since the device's clock() was last emptied.
struct Spent {
  double seconds = 0;
  int calls = 0;
};

// What a device is to run: each is a program of its own, which takes its compiler some time.
enum class Kernels { Contact, Digitize, Cut };

class Device {
 public:
  // The first device that passes the self-test, GPUs before others. Throws std::runtime_error that
  // names every device that was refused and why, or says that there is none.
  // `profiling`: the queue notes when its commands begin and end; costs some time each.
  static std::shared_ptr<Device> open(bool profiling = false, Kernels kernels = Kernels::Contact);

  // The same device, memory and queue with other kernels.
  static std::shared_ptr<Device> beside(const Device& other, Kernels kernels);

  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const std::string& name() const { return name_; }
  cl::Context& context() { return context_; }
  cl::CommandQueue& queue() { return queue_; }
  cl::Kernel& kernel(const std::string& name);
  // One with arguments of its own, for a thread of its own.
  cl::Kernel another(const char* name) const { return {program_, name}; }
  std::size_t memory() const { return memory_; }          // [bytes]
  std::size_t largestBuffer() const { return largest_; }  // [bytes]
  std::size_t localBytes() const { return local_; }       // of a work-group
  bool gpu() const { return gpu_; }

  // Runs a kernel whose arguments are set, noted under its own name or another; `done` becomes its
  // event.
  void run(const char* name, std::size_t items, std::size_t group);
  void run(cl::Kernel& kernel, const char* name, std::size_t items, std::size_t group);
  void run(cl::CommandQueue& queue, cl::Kernel& kernel, const char* name, std::size_t items,
           std::size_t group, cl::Event* done = nullptr);
  // A queue beside the device's own: its commands may run while that one's do.
  cl::CommandQueue another();
  // An event to hand to a copy at once, noted under that name; null where nothing is noted.
  cl::Event* note(const char* name);
  // What each took; waits for the device's own queue, and begins anew. Other queues are to have
  // come to their ends. Throws std::runtime_error where the device fails.
  std::map<std::string, Spent> clock();

 private:
  Device(const cl::Device& device, bool profiling, Kernels kernels);
  Device(const Device& other, Kernels kernels);
  void begin(Kernels kernels);
  void build(const char* source);
  void checkLayout();
  void test();

  struct Noted {
    std::string name;
    std::thread::id by;
    cl::Event event;
  };
  void sumUp();

  cl::Device device_;
  cl::Context context_;
  cl::CommandQueue queue_;
  cl::Program program_;
  std::map<std::string, cl::Kernel, std::less<>> kernels_;
  std::mutex noting_;
  std::vector<std::unique_ptr<Noted>> notes_;
  std::size_t mostNotes_ = 0;
  std::map<std::string, Spent> summed_;  // of notes that are no more kept
  std::string name_;
  std::size_t memory_ = 0, largest_ = 0, local_ = 0;
  bool gpu_ = false, profiling_ = false;
};

}  // namespace cloudcontact::opencl
