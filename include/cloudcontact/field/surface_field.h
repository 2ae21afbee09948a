// SurfaceField: what a query asks of a cloud. For each voxel near the surface the base vector's
// direction and the signed depth (paper (4); DESIGN.md, "The method", 1-5), and the samples with
// which the cloud itself feels other bodies. Built once from a cloud, then shared by every body
// of that shape.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace cloudcontact {

struct FieldSettings {
  int threads = 0;                       // 0: all cores
  std::function<void(double)> progress;  // called with 0..1, may be empty
  // Keeps what renewed() starts from, for bodies that will be cut: doubles the field's memory.
  bool renewable = false;
};

// A piece of a cloud's own surface: the paper's collision voxel, as a quadrature point.
// In voxels, in the frame of the cloud's grid (origin at the grid's corner).
struct SurfaceSample {
  float position[3];  // on the surface
  float normal[3];    // outward unit
  float area;         // that it stands for [voxel^2]
  float width;        // of the piece itself, over which its depth varies [voxels]
};

// The answer of a field at a point, in the body's frame.
struct FieldPoint {
  double depth;  // [m], positive inside
  Vec3 normal;   // outward unit
};

class SurfaceField {
 public:
  // Builds the field. Throws std::invalid_argument on an empty cloud or one without a surface.
  static std::shared_ptr<const SurfaceField> build(const Cloud& cloud,
                                                   const FieldSettings& settings = {});

  virtual ~SurfaceField() = default;

  virtual const Cloud& cloud() const = 0;
  // Number of voxels in the band.
  virtual std::size_t bandVoxels() const = 0;
  virtual std::size_t bytes() const = 0;
  virtual std::size_t sampleCount() const = 0;
  // The k-th sample; the order is fixed by the cloud alone.
  virtual SurfaceSample sample(std::size_t k) const = 0;
  // Depth and normal at a point of the body's frame; nothing outside the band.
  virtual std::optional<FieldPoint> at(const Vec3& local) const = 0;
  // Lowest and highest corner of the surface, body's frame [m].
  virtual Eigen::AlignedBox3d bounds() const = 0;
  // Of all that a query reads: equal where two fields are, to the bit.
  virtual std::uint64_t hash() const = 0;
};

// The field of a cloud that was cut, or otherwise changed in places: equal to build(after), to the
// bit, but made anew only as far as the change reaches. `after` lies in the same grid of voxels
// (its origin may be another), as cutCloud() and pieces() give it. Can itself be renewed; where
// `before` was not built as renewable, all is built. Throws std::invalid_argument where the grid is
// another or nothing is left of the surface.
std::shared_ptr<const SurfaceField> renewed(const std::shared_ptr<const SurfaceField>& before,
                                            const Cloud& after, const FieldSettings& settings = {});

}  // namespace cloudcontact
