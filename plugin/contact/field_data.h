// The built field, as the contact finder reads it. SurfaceField's only implementation.
#pragma once

#include <cloudcontact/surface_field.h>

#include "field_builder.h"
#include "field_records.h"
#include "sample_set.h"

#include <vector>

namespace cloudcontact {

class FieldData final : public SurfaceField {
 public:
  FieldData(Cloud cloud, Band band, std::vector<SurfaceSample> samples);

  const Cloud& cloud() const override { return cloud_; }
  std::size_t bandVoxels() const override { return bandVoxels_; }
  std::size_t bytes() const override;
  std::size_t sampleCount() const override { return samples_.levels[0].samples.size(); }
  SurfaceSample sample(std::size_t k) const override { return samples_.levels[0].samples[k]; }
  std::optional<FieldPoint> at(const Vec3& local) const override;
  Eigen::AlignedBox3d bounds() const override { return bounds_; }

  const FieldRecords& records() const { return records_; }
  // The planes that records of several lead to.
  const CcVoxel* planes() const { return planes_.data(); }
  const SampleSet& samples() const { return samples_; }
  // How many bricks away (Chebyshev) the nearest brick of the band is, 255 at most; 0 inside the
  // band.
  const std::vector<std::uint8_t>& brickDistance() const { return distance_; }

 private:
  Cloud cloud_;
  std::size_t bandVoxels_;
  std::vector<CcVoxel> planes_;
  std::vector<std::uint8_t> distance_;
  FieldRecords records_;
  SampleSet samples_;
  Eigen::AlignedBox3d bounds_;
};

}  // namespace cloudcontact
