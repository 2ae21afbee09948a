// Which patch of the step before is this one.
#include "contact/patch_names.h"

namespace cloudcontact {

namespace {

constexpr double kSameCosine = 0.7;  // a patch is last step's if its normal is this near ...
constexpr double kSameVoxels = 8;    // ... and its centre

}  // namespace

void PatchNames::name(std::vector<NamedPatch>& patches, double voxel) {
  for (NamedPatch& patch : patches) {
    std::size_t best = known_.size();
    double nearest = kSameVoxels * voxel * kSameVoxels * voxel;
    for (std::size_t i = 0; i < known_.size(); ++i) {
      const double far = (known_[i].center - patch.center).squaredNorm();
      if (far > nearest || known_[i].normal.dot(patch.normal) < kSameCosine) continue;
      nearest = far;
      best = i;
    }
    if (best == known_.size()) {
      patch.id = next_++;
      continue;
    }
    patch.id = known_[best].id;
    known_.erase(known_.begin() + static_cast<std::ptrdiff_t>(best));
  }
  known_.assign(patches.begin(), patches.end());
}

}  // namespace cloudcontact
