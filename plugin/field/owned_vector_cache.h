// The base vectors (4) of a field's owned voxels (owned_voxels.h), as a BaseVectorField keeps them.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

namespace cloudcontact {

// Of each level, in the order of its voxels [voxels].
struct OwnedVectors {
  struct Level {
    std::vector<float> x, y, z, length;
  };
  std::vector<Level> levels;
};

// Those that a query read last, of one SurfaceField.
struct OwnedVectorCache {
  std::mutex mutex;
  std::weak_ptr<const int> field;  // FieldData::life()
  std::shared_ptr<const OwnedVectors> made;
};

}  // namespace cloudcontact
