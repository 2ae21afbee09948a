// FieldLevels: a body as surface fields of several voxel sizes, each built when it is first asked
// for. Coarse ones cost less to build, to keep and to search, and each knows, brick by brick, how
// far its surface is from the finest voxels' (docs/engine.md, "Levels").
#pragma once

#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/voxels/cloud.h>

#include <functional>
#include <memory>

namespace cloudcontact {

// All functions may be called from several threads at once; what they return depends on the cloud
// alone, not on who asks first.
class FieldLevels {
 public:
  // How a level's field is made of its cloud, as SurfaceField::build() does. One that keeps fields
  // in files, or shares them, may give one that it has.
  using Make =
      std::function<std::shared_ptr<const SurfaceField>(const Cloud&, const FieldSettings&)>;

  // Builds nothing yet. `settings`: of all fields; those of level 0 alone can be renewed. Throws
  // std::invalid_argument if the cloud is empty.
  explicit FieldLevels(const Cloud& finest, const FieldSettings& settings = {}, Make make = {});
  // Level 0 is this field. Throws std::invalid_argument if it is null.
  explicit FieldLevels(std::shared_ptr<const SurfaceField> finest,
                       const FieldSettings& settings = {});
  // Those of the body scaled by `factor`: fields are built once for both. Throws as
  // Cloud::scaled(), and if `of` is null.
  FieldLevels(std::shared_ptr<const FieldLevels> of, double factor);
  ~FieldLevels();
  FieldLevels(const FieldLevels&) = delete;
  FieldLevels& operator=(const FieldLevels&) = delete;

  // Level 0 has the finest voxels, those of cloud(). Each further one has voxels twice as large, as
  // long as the body is six of them thick along the axes of its grid.
  int count() const;
  const Cloud& cloud() const;
  double voxelSize(int level) const;  // [m]
  // The box around all voxels with matter in the finest cloud, body's frame [m].
  const Eigen::AlignedBox3d& bounds() const;

  // Built if needed. Null if the level has no surface (too thin for its voxels); level 0 throws as
  // SurfaceField::build() then.
  const std::shared_ptr<const SurfaceField>& field(int level) const;
  bool isBuilt(int level) const;
  // [m] How far the level's surface is from the finest voxels': the largest root mean square over
  // one of the level's voxels, in the whole body or in those bricks that `region` (body's frame
  // [m]) touches. By coverage, so at edges it states up to a third of a finest voxel too much.
  // Infinite where the level does not see a surface (a thin wall, a narrow slot). 0 for level 0.
  // Builds the level's field.
  double error(int level) const;
  double error(int level, const Eigen::AlignedBox3d& region) const;
  // The coarsest level whose error is at most `tolerance` [m]. Builds no finer ones than that.
  int coarsest(double tolerance) const;

  // Of the finest cloud and all that is built, with the levels' own clouds.
  std::size_t bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
