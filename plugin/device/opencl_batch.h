// The narrow phase of many pairs on an OpenCL device: uploads the poses, runs one chain of kernels
// for all pairs, downloads the contacts.
#pragma once

#include <cloudcontact/contact/contact.h>

#include "contact/contact_builder.h"
#include "contact/hit_search.h"
#include "device/device_fields.h"
#include "device/opencl_device.h"

#include <array>
#include <concepts>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

namespace cloudcontact::opencl {

// A pair to solve on the device. The bodies and settings outlive the batch.
struct DevicePair {
  const ContactBody *a = nullptr, *b = nullptr;
  const ContactSettings* settings = nullptr;
  PairFrame frame;
  std::uint32_t room = 0;  // hits that each direction may store
  // Indices of A's and B's in DeviceFields; that of a shape is the other's.
  std::uint32_t fields[2] = {0, 0};

  const ContactBody* shape() const { return a->shape ? a : b->shape ? b : nullptr; }
};

// A kernel that passes on only the arguments that changed since the last run. A batch has a hundred
// arguments, and setting all of them takes longer than the device should wait. Holds the buffers,
// so that no new buffer takes the address of a remembered one.
class CachedKernel {
 public:
  explicit CachedKernel(cl::Kernel kernel) : kernel_(std::move(kernel)) {}

  // Sets all arguments.
  template <typename... Arguments>
  cl::Kernel& with(const Arguments&... arguments) {
    cached_.resize(sizeof...(arguments));
    cl_uint k = 0;
    (set(k++, arguments), ...);
    return kernel_;
  }

 private:
  struct Cached {
    bool valid = false;
    std::int64_t number = 0;
    cl::Buffer buffer;
  };

  void set(cl_uint k, const cl::Buffer& buffer) {
    if (cached_[k].valid && cached_[k].buffer() == buffer()) return;
    pass(k, buffer);
    cached_[k].buffer = buffer;
  }
  void set(cl_uint k, std::integral auto number) {
    if (cached_[k].valid && cached_[k].number == std::int64_t{number}) return;
    pass(k, number);
    cached_[k].number = number;
  }
  template <typename Argument>
  void pass(cl_uint k, const Argument& argument) {
    cached_[k].valid = false;  // stays so if setArg() throws
    kernel_.setArg(k, argument);
    cached_[k].valid = true;
  }

  cl::Kernel kernel_;
  std::vector<Cached> cached_;
};

// One batch in its own queue, with its own buffers. Call reserve(), writePose() for each pair,
// search(), makeContacts() and finish() in this order. reserve(), search() and makeContacts() throw
// std::bad_alloc if the pairs do not fit in device memory together, and then hold none of it; and
// std::runtime_error if the device fails.
class OpenClBatch {
 public:
  OpenClBatch(std::shared_ptr<Device> device, std::shared_ptr<DeviceFields> fields)
      : device_(std::move(device)), fields_(std::move(fields)), queue_(device_->newQueue()) {}

  std::size_t bytes() const;  // device memory in use
  // Reserves memory for the pairs, which must stay where they are until finish(). Those of two
  // clouds come first.
  void reserve(std::span<const DevicePair> pairs);
  // Writes the k-th pair's poses into the upload buffer. Needs its frame; thread-safe; no throw.
  void writePose(std::size_t k);
  // Uploads the poses and enqueues the search. The fields must be uploaded.
  void search(BatchReport& report);
  // Enqueues the kernels that turn hits into contacts, and the download.
  void makeContacts();
  // Waits for the queue and ignores errors.
  void finishQuietly();
  // Waits for all but the last kernels.
  void waitForPatches();
  // Waits for the download. Throws std::runtime_error if the device fails.
  void finish(BatchReport& report);
  // Sets the finest level that a pair of this batch needed; call once all answers are read.
  void setFinest(int level);
  // Outcome of the k-th pair, and its contacts if it did not fail.
  const CcAnswer& answer(std::size_t k) const { return hostResults_->answers[k]; }
  std::span<const CcContactPatch> contacts(std::size_t k) const;

 private:
  template <typename... Arguments>
  void run(const Launch& launch, const Arguments&... arguments);
  template <typename Work>
  void enqueue(Work&& work);
  void send(BatchReport& report);
  std::size_t shapes() const { return count_ - clouds_; }
  CcShape* hostShapes() { return reinterpret_cast<CcShape*>(hostPairs_ + count_); }
  void reserveResults();
  void searchLevels();
  void growPatches();
  void makePoints(const cl::Buffer& bins, const cl::Buffer& grown, const cl::Buffer& patches);
  void fetch();
  void wait(const cl::Event& event);
  void release();

  std::shared_ptr<Device> device_;
  std::shared_ptr<DeviceFields> fields_;
  cl::CommandQueue queue_;
  std::map<std::string, CachedKernel, std::less<>> kernels_;
  PinnedMemory sent_, fetched_;
  DeviceBuffer pairs_, shapes_, results_, found_, nearby_, hits_, aside_, keys_, slots_, order_,
      bins_, sums_, sprouts_, queues_, scratch_, grown_, patches_, forces_, wholes_, listed_,
      placed_, heaviest_, places_, facing_, around_, neighbors_;
  static const std::array<DeviceBuffer OpenClBatch::*, 26> kBuffers;  // all of these
  // Where a direction's hits begin, and its samples near the other body.
  struct Offsets {
    std::uint32_t hits, nearby[2];
  };
  std::span<const DevicePair> devicePairs_;
  std::vector<Offsets> offsets_;
  CcPair* hostPairs_ = nullptr;  // and the shapes behind them
  std::size_t count_ = 0, clouds_ = 0, hitRoom_ = 0, nearbyRoom_ = 0;
  std::size_t contactsBegin_ = 0;  // in bytes
  // The search goes down to the finest level of the last two batches. The CPU solves pairs that
  // need a finer one.
  cl_int finest_ = 0, lastFinest_ = 0;
  std::uint32_t binRoom_ = 0, patchRoom_ = 0;
  std::uint32_t neededBins_ = 0, neededPatches_ = 0, neededContacts_ = 0, fetchedContacts_ = 0;
  const CcResults* hostResults_ = nullptr;
  const CcContactPatch* hostContacts_ = nullptr;
  cl::Event patchesDone_, fetchDone_;
};

}  // namespace cloudcontact::opencl
