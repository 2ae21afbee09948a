// Memory that only grows: see device_memory.h.
#include "device/device_memory.h"

#include <new>

namespace cloudcontact::opencl {

// What stays mapped is never given back: PoCL keeps the buffer.
void Pinned::giveBack() {
  if (!data_) return;
  ::clEnqueueUnmapMemObject(queue_(), buffer_(), data_, 0, nullptr, nullptr);
  ::clFinish(queue_());
  buffer_ = cl::Buffer();
  data_ = nullptr;
  size_ = 0;
}

void* Pinned::room(Device& device, std::size_t size) {
  if (size <= size_) return data_;
  giveBack();  // there is nothing until there is more: making it may throw
  const std::size_t more = size + size / 4;
  queue_ = device.queue();
  buffer_ = cl::Buffer(device.context(), CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, more);
  data_ = queue_.enqueueMapBuffer(buffer_, CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, more);
  size_ = more;
  return data_;
}

const cl::Buffer& Grown::room(Device& device, std::size_t size) {
  if (size > size_) {
    buffer_ = cl::Buffer();
    size_ = 0;  // until there is more: making it may throw
    const std::size_t more = size + size / 4;
    if (more > device.largestBuffer()) throw std::bad_alloc();
    buffer_ = cl::Buffer(device.context(), CL_MEM_READ_WRITE, more);
    size_ = more;
  }
  return buffer_;
}

const cl::Buffer& PartOf::of(const cl::Buffer& whole, std::size_t begin, std::size_t size) {
  if (part_() && whole_() == whole() && begin_ == begin && size_ == size) return part_;
  part_ = cl::Buffer();  // until there is another: making it may throw
  const cl_buffer_region region{begin, size};
  whole_ = whole;
  part_ = whole_.createSubBuffer(CL_MEM_READ_WRITE, CL_BUFFER_CREATE_TYPE_REGION, &region);
  begin_ = begin;
  size_ = size;
  return part_;
}

}  // namespace cloudcontact::opencl
