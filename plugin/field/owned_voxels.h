// OwnedVoxels: which piece of a body's surface each of its voxels belongs to. Each sample of level
// 0 owns the voxels that it is the nearest to, down to the middle of the body. A coarse sample owns
// what the samples that it stands for own. So a query that knows which samples lie in another body
// knows where to look for the voxels that do: the collision voxels B.
#pragma once

#include <cloudcontact/field/base_vector_field.h>

#include "base/large_memory.h"
#include "field/field_data.h"
#include "field/owned_vector_cache.h"

namespace cloudcontact {

// How far a sample's voxels reach [voxels]: those just below it beside it and above its plane, and
// all of them below.
struct OwnedReach {
  float aside = 0, above = 0, below = 0;

  // By how much some of them may be deeper in another body than the sample is. `facing`: cosine
  // between the sample's normal and the other's.
  float deeper(float facing) const {
    const float slope = CC_SQRT(ccMax(1.0f - facing * facing, 0.0f));
    return aside * slope + ccMax(-facing * above, facing * below);
  }
};

// A voxel's indices, of up to 2^15 along each axis, coverage [1/255] and material, in 8 bytes:
// where memory is slow, less is faster.
struct OwnedVoxel {
  std::uint32_t xy = 0, rest = 0;

  static OwnedVoxel of(const Eigen::Vector3i& v, std::uint8_t coverage, std::uint8_t material) {
    return {std::uint32_t(v.x()) | std::uint32_t(v.y()) << 16,
            std::uint32_t(v.z()) | std::uint32_t(coverage) << 16 | std::uint32_t(material) << 24};
  }
  // The center [voxels].
  float x() const { return float(int(xy & 0xffffu)) + 0.5f; }
  float y() const { return float(int(xy >> 16)) + 0.5f; }
  float z() const { return float(int(rest & 0xffffu)) + 0.5f; }
  Eigen::Vector3f center() const { return {x(), y(), z()}; }
  float coverage() const { return float(int(rest >> 16 & 0xffu)) * (1 / 255.0f); }
  std::uint8_t material() const { return std::uint8_t(rest >> 24); }
};

// A sample and its voxels, and the boxes around these, each of at most OwnedVoxels::kBoxed.
struct OwnedRun {
  float at[3], normal[3];          // [voxels]
  std::uint32_t first, last, box;  // `last`: the end

  std::uint32_t size() const { return last - first; }
};

// Middles and half edges of boxes around the centers of voxels, side by side.
struct OwnedBoxes {
  LargeVector<float> x, y, z, halfX, halfY, halfZ;
};

struct OwnedVoxels {
  static constexpr int kBoxed = 16;
  // Columns go on for so many voxels and boxes, so that whole vectors can be read.
  static constexpr int kBeyond = kBoxed;

  // Voxels in the order of their samples on a level. Those of a sample are sorted by their depth
  // below its plane.
  struct Level {
    LargeVector<OwnedRun> runs;  // of each sample
    LargeVector<OwnedReach> reach;
    OwnedBoxes boxes;
    LargeVector<OwnedVoxel> voxels;

    std::size_t size() const { return voxels.size() - kBeyond; }
  };
  Level levels[kLevels];

  std::size_t bytes() const;
};

// Made when it is first asked for, and kept with the field.
const OwnedVoxels& ownedVoxels(const FieldData& field);

// Their base vectors. Made when first asked for after a cut, and kept with the base vectors. Both
// must be of one cloud.
std::shared_ptr<const OwnedVectors> ownedVectors(const FieldData& field,
                                                 const BaseVectorField& vectors);

}  // namespace cloudcontact
