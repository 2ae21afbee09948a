// The built field, as the contact finder reads it. SurfaceField's only implementation.
#pragma once

#include <cloudcontact/surface_field.h>

#include "field_builder.h"
#include "sample_set.h"

#include <vector>

namespace cloudcontact {

class FieldData final : public SurfaceField {
 public:
  FieldData(Cloud cloud, Band band, std::vector<SurfaceSample> samples);

  const Cloud& cloud() const override { return cloud_; }
  std::size_t bandVoxels() const override { return band_.voxels; }
  std::size_t bytes() const override;
  std::size_t sampleCount() const override { return samples_.levels[0].samples.size(); }
  SurfaceSample sample(std::size_t k) const override { return samples_.levels[0].samples[k]; }
  std::optional<FieldPoint> at(const Vec3& local) const override;
  Eigen::AlignedBox3d bounds() const override { return bounds_; }

  const Band& band() const { return band_; }
  const SampleSet& samples() const { return samples_; }
  // How many bricks away (Chebyshev) the nearest brick of the band is, 255 at most; 0 inside the
  // band.
  const std::vector<std::uint8_t>& brickDistance() const { return distance_; }
  // False where no voxel of the band lies within four voxels; a voxel of the grid.
  bool near(int x, int y, int z) const {
    return near_[band_.grid.tableIndex(x, y, z)] >> ((x >> 2 & 1) | (y >> 1 & 2) | (z & 4)) & 1;
  }

 private:
  void measureDistance();
  void markNear();

  Cloud cloud_;
  Band band_;
  SampleSet samples_;
  std::vector<std::uint8_t> distance_;
  std::vector<std::uint8_t> near_;  // a bit for each 4x4x4 block of a brick
  Eigen::AlignedBox3d bounds_;
};

}  // namespace cloudcontact
