// The contacts of many pairs at once, on all cores or on an OpenCL device. Both give the same bits
// as a ContactFinder for each pair.
#pragma once

#include <cloudcontact/base/span.h>
#include <cloudcontact/contact/contact.h>
#include <cloudcontact/device/backend.h>

#include <map>
#include <memory>
#include <string>

namespace cloudcontact {

// Two bodies, and how their contact is searched.
struct BatchPair {
  ContactBody a, b;
  ContactSettings settings;
};

class ContactBatch {
 public:
  // Falls back to the CPU if no device computes the same bits as the CPU; message() says why.
  explicit ContactBatch(const BatchSettings& settings = {});
  ~ContactBatch();
  ContactBatch(ContactBatch&&) noexcept;
  ContactBatch& operator=(ContactBatch&&) noexcept;

  Backend backend() const;             // in use
  const std::string& message() const;  // why the CPU is used instead of the device, or empty
  const std::string& device() const;   // name of the OpenCL device; empty on the CPU

  // The contacts of each pair, valid until the next call. A pair that keeps its index in the list
  // keeps its point IDs. Surface fields stay in device memory while they exist. Throws as
  // ContactFinder::find() does, and std::runtime_error if the device fails or lacks the memory for
  // the fields.
  Span<const ContactResult* const> find(Span<const BatchPair> pairs);

  const BatchReport& report() const;                // of the last find()
  std::size_t deviceBytes() const;                  // device memory in use [bytes]
  std::map<std::string, DeviceTime> deviceTimes();  // since the last call; needs settings.timing

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
