// SurfaceField: the surface of a cloud, ready for queries. Every voxel near the surface holds the
// plane or planes fitted to its coverage, which give a signed depth and a fitted normal
// (docs/engine.md, "Depth from the window" and "Edges"). The cloud's own surface is also divided
// into samples, which are looked up in the fields of other bodies (docs/force.md, "Samples").
// Built once per cloud and shared by all bodies of that shape.
#pragma once

#include <cloudcontact/field/surface_sample.h>
#include <cloudcontact/voxels/cloud.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

namespace cloudcontact {

class FieldData;

// How a field is built or renewed.
struct FieldSettings {
  int threads = 0;                       // 0: all cores
  std::function<void(double)> progress;  // called with 0..1; may be empty
  // Keeps the data that renewed() starts from, for bodies that will be cut. Takes several
  // times the memory.
  bool renewable = false;
  // The most edge searches that a renewal makes, or a build of a renewable field; empty: all. What
  // is left waits in the new field (SurfaceField::unsettled()), and later renewals go on with it.
  std::optional<int> edgeSearches;
  // Called between the parts of a renewal with what a part has cost [about microseconds of one
  // core, by counts, never by a clock]. It may wait, which spreads a renewal over time, and what it
  // throws ends the renewal. May be empty.
  std::function<void(double)> spend;
};

// Depth and normal at a point, in the body's frame.
struct FieldPoint {
  double depth;  // [m], positive inside
  Vec3 normal;   // outward unit vector
};

class SurfaceField final {
 public:
  // Throws std::invalid_argument if the cloud is empty, has no surface, or has more than 32767
  // voxels along an axis.
  static std::shared_ptr<const SurfaceField> build(const Cloud& cloud,
                                                   const FieldSettings& settings = {});
  // For build() and renewed().
  explicit SurfaceField(std::shared_ptr<const FieldData> data) : data_(std::move(data)) {}

  const Cloud& cloud() const;
  // Number of voxels that hold planes: the band around the surface.
  std::size_t bandVoxels() const;
  std::size_t bytes() const;
  std::size_t sampleCount() const;
  // The k-th sample. The order depends on the cloud alone.
  SurfaceSample sample(std::size_t k) const;
  // Depth and normal at a point of the body's frame; empty outside the band.
  std::optional<FieldPoint> at(const Vec3& local) const;
  // Bounds of the samples, body's frame [m].
  Eigen::AlignedBox3d bounds() const;
  // Voxels whose edges are still to be searched. 0: settled, equal to build(cloud()) to the bit.
  // Until then their surface is smooth: an edge that was just cut is blunt (30 deg within a voxel).
  std::size_t unsettled() const;
  // Hash of all data that queries read. Equal fields have equal hashes on every machine.
  std::uint64_t hash() const;

  // The library's own view (plugin/field/field_data.h): records and samples as the contact finder
  // reads them. Not for users of the library.
  const FieldData& data() const { return *data_; }

 private:
  std::shared_ptr<const FieldData> data_;
};

// The field of a cloud that was cut or changed elsewhere. Equal to build(after) to the bit once it
// is settled, but recomputes only what the change can affect. `after` must have the same grid of
// voxels as before->cloud(), although its origin may differ; cutCloud() and pieces() return such
// clouds. The result is itself renewable. If `before` was built without FieldSettings::renewable,
// everything is built. Throws std::invalid_argument if the grid differs or no surface is left.
std::shared_ptr<const SurfaceField> renewed(const std::shared_ptr<const SurfaceField>& before,
                                            const Cloud& after, const FieldSettings& settings = {});

// The field of field.cloud().scaled(factor), equal to build() of that to the bit, but copied: all
// its data are in voxels. Not renewable. Throws as Cloud::scaled().
std::shared_ptr<const SurfaceField> scaled(const SurfaceField& field, double factor);

}  // namespace cloudcontact
