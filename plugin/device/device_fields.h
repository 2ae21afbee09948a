// Fields in a device's memory: one buffer holds them all, so that one launch serves pairs of
// different fields.
#pragma once

#include "device/opencl_device.h"
#include "field/field_data.h"
#include "kernels/contact/batch_layout.h"

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

namespace cloudcontact::opencl {

class DeviceFields {
 public:
  explicit DeviceFields(std::shared_ptr<Device> device) : device_(std::move(device)) {}

  // The field's number in the table; it is sent where the device does not have it. Throws
  // std::runtime_error where it does not fit, with how much it needs and what there is.
  std::uint32_t numberOf(const FieldData& field);
  // Samples of each level.
  const std::uint32_t* counts(std::uint32_t number) const { return kept_[number].entry.counts; }
  // Sends the table where it has changed. The fields' data: call after all numbers are asked for.
  void settle();
  const cl::Buffer& table() const { return table_; }
  const cl::Buffer& data() const { return data_; }
  std::size_t bytes() const { return room_; }

 private:
  struct Kept {
    const FieldData* field = nullptr;
    std::weak_ptr<const int> life;
    std::size_t begin = 0, size = 0;  // [bytes]
    CcField entry{};
  };
  std::uint32_t send(const FieldData& field);
  std::size_t place(std::size_t size);
  void enlarge(std::size_t size);
  void forgetDead();

  std::shared_ptr<Device> device_;
  std::vector<Kept> kept_;
  std::unordered_map<const FieldData*, std::uint32_t> numbers_;
  cl::Buffer data_, table_;
  std::size_t room_ = 0, tableRoom_ = 0;
  bool changed_ = false;
};

}  // namespace cloudcontact::opencl
