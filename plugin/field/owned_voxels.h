// OwnedVoxels: which piece of a body's surface each of its voxels belongs to. Each sample of level
// 0 owns the voxels that it is the nearest to, down to the middle of the body. A coarse sample owns
// what the samples that it stands for own. So a query that knows which samples lie in another body
// knows where to look for the voxels that do: the collision voxels B.
#pragma once

#include <cloudcontact/field/base_vector_field.h>

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

struct OwnedVoxels {
  // Of each voxel: its center in the grid's frame [voxels], coverage and material. In the order of
  // the coarsest samples, whose voxels are read most.
  std::vector<float> x, y, z;
  std::vector<std::uint8_t> coverage, material;

  struct Level {
    // Of each sample its first voxel in `order`, and the end; those of a sample are sorted by their
    // depth below its plane. The coarsest level has no `order`: it is that of the voxels.
    std::vector<std::uint32_t> firsts, order;
    std::vector<OwnedReach> reach;  // of each sample
  };
  Level levels[kLevels];

  // The columns of centers go on for so many numbers, so that whole vectors can be read.
  static constexpr int kBeyond = 16;
  std::size_t size() const { return coverage.size(); }
  std::size_t bytes() const;
};

// Made when it is first asked for, and kept with the field.
const OwnedVoxels& ownedVoxels(const FieldData& field);

// Their base vectors. Made when first asked for after a cut, and kept with the base vectors. Both
// must be of one cloud.
std::shared_ptr<const OwnedVectors> ownedVectors(const FieldData& field,
                                                 const BaseVectorField& vectors);

}  // namespace cloudcontact
