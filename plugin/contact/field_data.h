// The built field, as the contact finder reads it. SurfaceField's only implementation.
#pragma once

#include <cloudcontact/surface_field.h>

#include "field_builder.h"

#include <vector>

namespace cloudcontact {

// The samples of one brick, contiguous; `radius` about `center` holds them all (grid frame,
// voxels).
struct SampleBrick {
  float center[3];
  float radius;
  std::uint32_t first, count;
};

class FieldData final : public SurfaceField {
 public:
  FieldData(Cloud cloud, Band band, std::vector<SurfaceSample> samples);

  const Cloud& cloud() const override { return cloud_; }
  std::size_t bandVoxels() const override { return band_.voxels; }
  std::size_t bytes() const override;
  std::size_t sampleCount() const override { return samples_.size(); }
  SurfaceSample sample(std::size_t k) const override { return samples_[k]; }
  std::optional<FieldPoint> at(const Vec3& local) const override;
  Eigen::AlignedBox3d bounds() const override { return bounds_; }

  const Band& band() const { return band_; }
  const std::vector<SurfaceSample>& samples() const { return samples_; }
  const std::vector<SampleBrick>& sampleBricks() const { return bricks_; }
  // How many bricks away (Chebyshev) the nearest brick of the band is, 255 at most; 0 inside the
  // band.
  const std::vector<std::uint8_t>& brickDistance() const { return distance_; }

 private:
  void groupSamples();
  void measureDistance();

  Cloud cloud_;
  Band band_;
  std::vector<SurfaceSample> samples_;
  std::vector<SampleBrick> bricks_;
  std::vector<std::uint8_t> distance_;
  Eigen::AlignedBox3d bounds_;
};

}  // namespace cloudcontact
