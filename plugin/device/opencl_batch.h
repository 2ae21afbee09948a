// The batched narrow phase on an OpenCL device: poses go up, one chain of kernels runs for all
// pairs, its contacts come down.
#pragma once

#include <cloudcontact/device/contact_batch.h>

#include "contact/finder_scratch.h"
#include "device/device_fields.h"
#include "device/device_guard.h"
#include "device/device_memory.h"
#include "device/prepared_kernel.h"

#include <array>
#include <map>
#include <span>

namespace cloudcontact::opencl {

// A pair that the device is asked for.
struct Asked {
  const BatchPair* pair = nullptr;
  PairFrame frame;
  std::uint32_t room = 0;            // hits that each direction may have
  std::uint32_t fields[2] = {0, 0};  // numbers of A's and B's
};

// A batch on its way, its queue and the memory that it works in.
class OpenClBatch {
 public:
  OpenClBatch(std::shared_ptr<Device> device, std::shared_ptr<DeviceFields> fields)
      : device_(std::move(device)), fields_(std::move(fields)), queue_(device_->another()) {}

  std::size_t bytes() const;
  // A batch goes through these in turn. Each throws std::bad_alloc where the pairs are too many for
  // the device at once, and then holds no memory of it; std::runtime_error where the device fails.
  // Makes room for the pairs, which stay where they are until they are searched.
  void place(std::span<const Asked> pairs);
  // The k-th pair's poses go where they are sent from; from any thread, its frame known. Throws
  // nothing.
  void pose(std::size_t k);
  // Hands over the poses and the search; the fields must be there.
  void search(BatchReport& report);
  // Hands over what makes contacts of hits, and their way back.
  void gather();
  // Waits for it, whatever it came to.
  void finishQuietly();
  // Waits until it has come to its last kernels.
  void nearEnd();
  // Waits for it. Throws std::runtime_error where the device fails.
  void finish(BatchReport& report);
  // The finest level that a pair wanted, once all have been asked what became of them.
  void learn(int finest);
  // What became of the k-th pair; contacts() of it where it did not fail.
  const CcAnswer& answer(std::size_t k) const { return answers_[k]; }
  std::span<const CcContactPatch> contacts(std::size_t k) const;

 private:
  struct Launch {
    const char* kernel;
    std::size_t items, group;
    const char* noted = nullptr;  // its name in reports, where it is another
    cl::Event* done = nullptr;
  };
  PreparedKernel& kernel(const char* name);
  template <typename... Arguments>
  void run(const Launch& how, const Arguments&... arguments);
  template <typename Work>
  void handOver(Work&& work);
  void send(BatchReport& report);
  void makeRoom();
  void searchLevels();
  void growPatches();
  void fetch();
  void wait(const cl::Event& event);
  void giveBack();

  std::shared_ptr<Device> device_;
  std::shared_ptr<DeviceFields> fields_;
  cl::CommandQueue queue_;
  std::map<std::string, PreparedKernel, std::less<>> kernels_;  // arguments of a queue's own
  Pinned sent_, fetched_;
  Grown tasks_, results_, found_, nearby_, hits_, aside_, keys_, slots_, order_, bins_, sums_,
      sprouts_, queues_, scratch_, grown_, patches_, forces_, kept_, heaviest_, near_, neighbours_;
  static const std::array<Grown OpenClBatch::*, 21> kGrown;  // all of these
  PartOf directions_, pairs_;                                // of tasks_
  PartOf answersThere_, counters_, contacts_;                // of results_
  // Where a direction's hits go, and its samples near the other body.
  struct Place {
    std::uint32_t hits, nearby[2];
  };
  std::span<const Asked> asked_;
  std::vector<Place> places_;
  CcDirection* directionsHere_ = nullptr;
  CcPair* pairsHere_ = nullptr;
  std::size_t count_ = 0, hitRoom_ = 0, nearbyRoom_ = 0, contactsBegin_ = 0;
  // The finest level that pairs are searched on: that of the last two batches. Who turns out to
  // want a finer one is the CPU's this time.
  cl_int finest_ = 0, finestBefore_ = 0;
  std::uint32_t binRoom_ = 0, patchRoom_ = 0;
  std::uint32_t binsWanted_ = 0, patchesWanted_ = 0, contactsWanted_ = 0, contactsAsked_ = 0;
  const CcAnswer* answers_ = nullptr;
  const std::uint32_t* countersHere_ = nullptr;
  const CcContactPatch* contactsHere_ = nullptr;
  cl::Event grownAll_, fetchedAll_;
};

}  // namespace cloudcontact::opencl
