// What a cut leaves of a body: its pieces, each with its matter and its field. The work of finding
// them may be spread over the steps of a world.
#pragma once

#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/voxels/matter_sums.h>
#include <cloudcontact/voxels/voxel_cut.h>

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/paced_task.h"

namespace cloudcontact {

// A body's matter and the field of its surface.
struct BodyMatter {
  Cloud cloud;
  std::vector<MatterSums> sums;  // of the cloud
  std::shared_ptr<const SurfaceField> field;
  bool whole = false;  // the field's cloud is known to be one part
};

// How a body is cut to pieces (CuttableBodySettings).
struct PieceSettings {
  std::vector<double> densities;
  double leastPiece = 0;  // [kg]
  int threads = 0;
};

// Coverage of all materials [1/255].
std::int64_t coverageOf(const std::vector<MatterSums>& sums);
std::vector<MatterSums> sumOf(const std::vector<MatterSums>& a, const std::vector<MatterSums>& b,
                              bool less);
double bodyMass(const BodyMatter& matter, const std::vector<double>& densities);

// Of a field that will be cut.
FieldSettings fieldSettings(int threads, std::optional<int> edgeSearches);

// The pieces of `after`, the matter that is left of a body, with fields renewed from the body's. In
// the order of their first voxels; without those lighter than PieceSettings::leastPiece, and
// those that have no surface. `spend` may be empty (FieldSettings::spend).
std::vector<BodyMatter> piecesOf(const BodyMatter& body, const Cloud& after,
                                 const PieceSettings& settings,
                                 const std::function<void(double)>& spend);

// The same in slices. `matter`: what is left of the body, crumbs included.
struct PieceWork {
  BodyMatter matter;
  std::shared_ptr<std::vector<BodyMatter>> pieces;  // once the task is done
  std::vector<VoxelCut> since;                      // cuts made after it began
  PacedTask task;

  PieceWork(const BodyMatter& body, BodyMatter left, const PieceSettings& settings);
};

// `body` after cuts. Its field stays as it is.
BodyMatter cutMatter(const BodyMatter& body, std::span<const VoxelCut> cuts);

}  // namespace cloudcontact
