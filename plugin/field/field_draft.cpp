// The builder's bricks: shared with the field before until they are written to.
#include "field/field_builder.h"

namespace cloudcontact {

FieldDraft::FieldDraft(const Cloud& wholeCloud, const FieldSettings& how, SurfaceBricks before)
    : cloud(wholeCloud),
      settings(how),
      size_(cloud.size()),
      nx_(static_cast<std::size_t>(cloud.bricks().x())),
      ny_(static_cast<std::size_t>(cloud.bricks().y())),
      bricks_(std::move(before)),
      own_(cloud.voxels().table.size(), nullptr) {
  bricks_.resize(own_.size());
}

SurfaceBrick& FieldDraft::write(std::size_t t) {
  if (!own_[t]) {
    auto brick =
        bricks_[t] ? std::make_shared<SurfaceBrick>(*bricks_[t]) : std::make_shared<SurfaceBrick>();
    own_[t] = brick.get();
    bricks_[t] = std::move(brick);
  }
  return *own_[t];
}

void FieldDraft::compact() {
  for (std::size_t t = 0; t < own_.size(); ++t) {
    if (!own_[t]) continue;
    own_[t]->compact();
    if (!own_[t]->voxels.empty()) continue;
    own_[t] = nullptr;
    bricks_[t] = nullptr;
  }
}

std::vector<std::int32_t> FieldDraft::surfaceBricks() const {
  std::vector<std::int32_t> numbers;
  for (std::size_t t = 0; t < bricks_.size(); ++t)
    if (bricks_[t] && !bricks_[t]->voxels.empty()) numbers.push_back(static_cast<std::int32_t>(t));
  return numbers;
}

Eigen::Vector3i FieldDraft::cornerOf(std::size_t t) const {
  return kBrickEdge * Eigen::Vector3i(static_cast<int>(t % nx_), static_cast<int>(t / nx_ % ny_),
                                      static_cast<int>(t / nx_ / ny_));
}

}  // namespace cloudcontact
