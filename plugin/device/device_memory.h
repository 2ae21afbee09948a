// Memory that grows as it is needed, on the device and beside it, and how kernels are given theirs.
#pragma once

#include "device/opencl_device.h"

namespace cloudcontact::opencl {

// Memory that the device copies from and to at full speed, kept as long as nothing larger is
// needed.
class Pinned {
 public:
  Pinned() = default;
  ~Pinned() { giveBack(); }
  Pinned(const Pinned&) = delete;
  Pinned& operator=(const Pinned&) = delete;

  // At least `size` bytes; what was there is lost where it grows.
  void* room(Device& device, std::size_t size);
  void* data() const { return data_; }
  void giveBack();

 private:
  cl::CommandQueue queue_;  // in which it was mapped
  cl::Buffer buffer_;
  void* data_ = nullptr;
  std::size_t size_ = 0;
};

// A device's buffer that only grows.
class Grown {
 public:
  const cl::Buffer& room(Device& device, std::size_t size);
  const cl::Buffer& buffer() const { return buffer_; }
  std::size_t bytes() const { return size_; }

 private:
  cl::Buffer buffer_;
  std::size_t size_ = 0;
};

// Some of a buffer's bytes as a buffer of their own, the same as long as they are the same.
class PartOf {
 public:
  // `begin` a multiple of what the device asks for.
  const cl::Buffer& of(const cl::Buffer& whole, std::size_t begin, std::size_t size);
  const cl::Buffer& buffer() const { return part_; }

 private:
  cl::Buffer whole_, part_;
  std::size_t begin_ = 0, size_ = 0;
};

// Sets all of a kernel's arguments.
template <typename... Arguments>
void give(cl::Kernel& kernel, const Arguments&... arguments) {
  cl_uint k = 0;
  (kernel.setArg(k++, arguments), ...);
}

}  // namespace cloudcontact::opencl
