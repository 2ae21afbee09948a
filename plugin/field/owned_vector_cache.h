// The base vectors (4) of a field's owned voxels (owned_voxels.h), as a BaseVectorField keeps them.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

namespace cloudcontact {

// In the order of the voxels [voxels].
struct OwnedVectors {
  std::vector<float> x, y, z;
};

// Those that a query read last, of one SurfaceField.
struct OwnedVectorCache {
  std::mutex mutex;
  std::weak_ptr<const int> field;  // FieldData::life()
  std::shared_ptr<const OwnedVectors> made;
};

}  // namespace cloudcontact
