// DeviceSearch: searches pairs on an OpenCL device, each by a finder of its own. It leaves out
// the pairs that the device cannot answer. ContactBatch and CloudDispatcher search the others on
// the CPU, with equal results.
#pragma once

#include <cloudcontact/contact/contact.h>
#include <cloudcontact/device/backend.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>

namespace cloudcontact {

class ContactFinder;

// A pair to search. All that it points to outlives the call.
struct SearchTask {
  const ContactBody *a = nullptr, *b = nullptr;
  const ContactSettings* settings = nullptr;
  ContactFinder* finder = nullptr;
  ContactResult* found = nullptr;  // gets the contact, as by ContactFinder::search()
  std::uint32_t* room = nullptr;   // hits that each direction may store; keep it between calls
  bool named = false;              // with the points' IDs, as by ContactFinder::find()
  bool answered = false;           // out: whether the device did it
  // The last search found no touch. The CPU finds near misses, so the device need not look first.
  bool apart = false;

  static constexpr std::uint32_t kFirstRoom = 2048;
};

class DeviceSearch {
 public:
  // Throws std::runtime_error if no device computes the same bits as the CPU.
  explicit DeviceSearch(const BatchSettings& settings);
  ~DeviceSearch();

  const std::string& device() const;  // name
  // Whether there are kernels for such a pair, which touched last: two clouds, or a cloud and a
  // plain solid (law/kernel_solid.h), without tissues or base vectors. The device still leaves it
  // out where the bodies do not touch, an edge of the solid does, or it lacks the memory.
  static bool takes(const SearchTask& task);
  // Sets `answered` of all tasks. `meanwhile` runs while the device works. Throws as
  // ContactBatch::find(); then no task counts as answered.
  void run(std::span<SearchTask> tasks, const std::function<void()>& meanwhile = {});

  const BatchReport& report() const;                // of the last run(); `onCpu` is 0
  std::size_t bytes() const;                        // device memory in use
  std::map<std::string, DeviceTime> deviceTimes();  // since the last call; needs settings.timing

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
