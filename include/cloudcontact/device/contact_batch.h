// The contacts of many pairs at once, on all cores or on an OpenCL device. Either gives what
// ContactFinder gives for each pair, to the bit.
#pragma once

#include <cloudcontact/contact/contact.h>

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace cloudcontact {

enum class Backend { Cpu, OpenCl };

struct BatchPair {
  ContactBody a, b;
  ContactSettings settings;
};

struct BatchSettings {
  Backend backend = Backend::Cpu;
  int threads = 0;      // of the CPU; 0: all cores
  bool timing = false;  // notes what each step on the device takes, which takes time itself
};

// What the last batch came to.
struct BatchReport {
  std::size_t onDevice = 0, onCpu = 0;  // pairs
  // Of these on the CPU: found no room on the device (the next batch makes more; but pairs of more
  // than 1,024 bins, or a million hits a side, are too large for it), want finer samples than any
  // pair of the last two batches (the next batch asks for them), hardly touch within their margin,
  // or are no two clouds: near misses and shapes are the CPU's alone so far.
  std::size_t noRoom = 0, finer = 0, nearMisses = 0, shapes = 0;
  std::size_t asked = 0, hits = 0, bins = 0, patches = 0, contacts = 0;  // on the device
  std::size_t sent = 0, fetched = 0;                                     // [bytes]
};

// What a step on the device took since it was last asked for.
struct DeviceTime {
  double seconds = 0;
  int calls = 0;
};

class ContactBatch {
 public:
  // Where there is no device that computes as the CPU does the batch runs on the CPU, and message()
  // says why.
  explicit ContactBatch(const BatchSettings& settings = {});
  ~ContactBatch();
  ContactBatch(ContactBatch&&) noexcept;
  ContactBatch& operator=(ContactBatch&&) noexcept;

  Backend backend() const;  // what it runs on
  const std::string& message() const;
  const std::string& device() const;  // the OpenCL device's name; empty on the CPU

  // The contacts of each pair; they hold until the next call. A pair that keeps its place in the
  // list keeps its points' names. Fields stay on the device as long as they live. Throws as
  // ContactFinder::find() does, and std::runtime_error where the device fails or cannot hold the
  // fields.
  std::span<const ContactResult* const> find(std::span<const BatchPair> pairs);

  const BatchReport& report() const;
  std::size_t deviceBytes() const;                  // that fields and working memory take there
  std::map<std::string, DeviceTime> deviceTimes();  // BatchSettings::timing

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace cloudcontact
