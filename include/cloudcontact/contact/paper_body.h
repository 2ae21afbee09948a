// PaperBody: what a body brings to a contact by the paper's method: its base vectors, its collision
// detection area D, and what it cuts with. Paper, Step 5; equations (4), (5) and (5')
// (docs/method.md, "Step 5: direction").
#pragma once

#include <cloudcontact/field/base_vector_field.h>
#include <cloudcontact/law/solid.h>

#include <memory>
#include <optional>
#include <vector>

namespace cloudcontact {

// A part of a tool that cuts better or worse than the rest.
struct CuttingPart {
  PlacedSolid area;  // in the tool's frame
  // Factor of the base vectors of voxels in the area. Where parts overlap, the last one counts.
  double ability = 1;
};

// The collision voxels B are the voxels of either body inside the other's D. Each counts by its
// share inside D, so the force does not jump as voxels come and go. The digital normal is the mean
// of their base vectors, each from its own body's C and Gr, times hardness and cutting ability.
struct PaperBody {
  // Of the same cloud as the body's SurfaceField; not null. Holds C, Gr and the tissues.
  std::shared_ptr<const BaseVectorField> vectors;
  std::optional<PlacedSolid> area;  // D, in the body's frame; empty: the whole body
  bool hardness = true;             // h in (5'); without it (5)
  double ability = 1;               // cutting ability outside all parts
  std::vector<CuttingPart> parts;
};

// How a PaperBody is made.
struct PaperSettings {
  std::optional<WindowSettings> window;  // C and Gr; empty: sphereWindow() of the cloud
  std::optional<PlacedSolid> area;       // PaperBody's fields
  bool hardness = true;
  double ability = 1;
  std::vector<CuttingPart> parts;
};

// `tissues`: one for each of the cloud's materials, one for all, or none. Throws
// std::invalid_argument, naming the field, where a setting is not valid, and as BaseVectorField
// does.
PaperBody paperBody(const Cloud& cloud, const TissueTable& tissues,
                    const PaperSettings& settings = {});

// The cutting ability at a point of the body's frame.
double abilityAt(const PaperBody& body, const Vec3& point);

// h of each tissue in (5'): its hardness over the first tissue's. 1 for a tissue without a
// hardness, as h must be positive, and for all where `hardness` is false.
std::vector<double> hardnessOf(const TissueTable& tissues, bool hardness);

}  // namespace cloudcontact
