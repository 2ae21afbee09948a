// Surface fields in device memory. One buffer holds all of them, so that one launch serves pairs
// with different fields.
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

  // The field's index in table(). Uploads the field if the device does not have it. Throws
  // std::runtime_error if it does not fit in device memory.
  std::uint32_t indexOf(const FieldData& field);
  // Number of samples on each level.
  const std::uint32_t* counts(std::uint32_t index) const { return kept_[index].entry.counts; }
  // Uploads the table if it changed. Call it after indexOf() for all fields of a batch.
  void sendTable();
  const cl::Buffer& table() const { return table_; }
  const cl::Buffer& data() const { return data_; }
  std::size_t bytes() const { return room_; }  // device memory in use

 private:
  struct Kept {
    const FieldData* field = nullptr;
    std::weak_ptr<const int> life;
    std::size_t begin = 0, size = 0;  // [bytes]
    CcField entry{};
  };
  std::uint32_t send(const FieldData& field);
  std::size_t findRoom(std::size_t size);
  void enlarge(std::size_t size);
  void forgetDead();

  std::shared_ptr<Device> device_;
  std::vector<Kept> kept_;
  std::unordered_map<const FieldData*, std::uint32_t> indices_;
  cl::Buffer data_, table_;
  std::size_t room_ = 0, tableRoom_ = 0;
  bool changed_ = false;
};

}  // namespace cloudcontact::opencl
