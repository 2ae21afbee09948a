// The batched narrow phase on an OpenCL device: poses go up, one chain of kernels runs for all
// pairs, the patches' sums come down.
#pragma once

#include <cloudcontact/batch.h>

#include "contact/finder_scratch.h"
#include "device_fields.h"

#include <span>

namespace cloudcontact::opencl {

// A pair that the device is asked for.
struct Asked {
  const BatchPair* pair = nullptr;
  PairFrame frame;
  std::uint32_t room[2] = {0, 0};  // hits that each direction may have
};

// Memory that the device copies from and to at full speed, kept as long as nothing larger is
// needed.
class Pinned {
 public:
  // At least `size` bytes; what was there is lost where it grows.
  void* room(Device& device, std::size_t size);
  void* data() const { return data_; }

 private:
  cl::Buffer buffer_;
  void* data_ = nullptr;
  std::size_t size_ = 0;
};

// A device's buffer that only grows.
class Grown {
 public:
  const cl::Buffer& room(Device& device, std::size_t size);
  std::size_t bytes() const { return size_; }

 private:
  cl::Buffer buffer_;
  std::size_t size_ = 0;
};

class OpenClBatch {
 public:
  explicit OpenClBatch(std::shared_ptr<Device> device);

  Device& device() { return *device_; }
  std::size_t bytes() const;
  // Runs the chain. Throws std::runtime_error where the device fails.
  void run(std::span<const Asked> pairs, BatchReport& report);
  // What became of the k-th pair; patches() of it where it did not fail.
  const CcAnswer& answer(std::size_t k) const { return answers_[k]; }
  std::span<const Sums> patches(std::size_t k) const;

 private:
  void send(std::span<const Asked> pairs, BatchReport& report);
  void launch(std::size_t pairs);
  void fetch(std::size_t pairs, BatchReport& report);

  std::shared_ptr<Device> device_;
  DeviceFields fields_;
  Pinned sent_, fetched_, fetchedSums_;
  Grown pairs_, directions_, counters_, found_, nearby_, hits_, aside_, keys_, slots_, order_,
      answersThere_, bins_, sums_, sprouts_, queues_, scratch_, grown_, patches_;
  std::size_t hitRoom_ = 0, nearbyRoom_ = 0;
  std::uint32_t binRoom_ = 0, patchRoom_ = 0;
  std::uint32_t binsWanted_ = 0, patchesWanted_ = 0;
  const CcAnswer* answers_ = nullptr;
  const Sums* sumsHere_ = nullptr;
};

}  // namespace cloudcontact::opencl
