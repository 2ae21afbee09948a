// The built field, as the contact finder reads it. SurfaceField's only implementation.
#pragma once

#include <cloudcontact/field/surface_field.h>

#include "field/field_builder.h"
#include "field/field_records.h"
#include "field/sample_set.h"

#include <vector>

namespace cloudcontact {

// What a renewal starts from: kept only where FieldSettings::renewable asks for it.
struct FieldNotes {
  SurfaceBricks bricks;
  std::vector<SampleOrigin> origins;  // of the samples
};

class FieldData final : public SurfaceField {
 public:
  // What the builder hands over. `before`: where the band's kept bricks are, and what else of an
  // earlier field still holds; null where all was built.
  struct Parts {
    Band band;
    SampleSet samples;
    std::shared_ptr<const FieldNotes> notes;
    const FieldData* before = nullptr;
  };
  FieldData(Cloud cloud, Parts parts);

  const Cloud& cloud() const override { return cloud_; }
  std::size_t bandVoxels() const override { return records_.bandVoxels(); }
  std::size_t bytes() const override;
  std::size_t sampleCount() const override { return samples_.levels[0].samples.size(); }
  SurfaceSample sample(std::size_t k) const override { return samples_.levels[0].samples[k]; }
  std::optional<FieldPoint> at(const Vec3& local) const override;
  Eigen::AlignedBox3d bounds() const override { return bounds_; }
  std::uint64_t hash() const override;

  const FieldRecords& records() const { return records_; }
  // The planes that records of several lead to.
  const CcVoxel* planes() const { return planes_.planes.data(); }
  std::size_t planeCount() const { return planes_.planes.size(); }
  const SampleSet& samples() const { return samples_; }
  // How many bricks away (Chebyshev) the nearest brick of the band is, 255 at most; 0 inside the
  // band.
  const std::vector<std::uint8_t>& brickDistance() const { return distance_; }
  // A brick as the band has it; without cells where it is none of the band's.
  BandView bandBrick(std::size_t brick) const;
  const FieldNotes* notes() const { return notes_.get(); }
  // Lives as long as the field, for those who keep a copy of what it holds.
  const std::shared_ptr<const int>& life() const { return life_; }

 private:
  FieldData(Cloud cloud, Parts& parts, const BandSource& source);

  Cloud cloud_;
  BandPlanes planes_;
  std::vector<std::uint8_t> distance_;
  FieldRecords records_;
  SampleSet samples_;
  Eigen::AlignedBox3d bounds_;
  std::shared_ptr<const FieldNotes> notes_;
  std::shared_ptr<const int> life_ = std::make_shared<const int>(0);
};

}  // namespace cloudcontact
