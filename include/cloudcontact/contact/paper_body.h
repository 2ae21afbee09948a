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

// Which voxels are in D.
enum class Membership : std::uint8_t {
  Whole,  // a voxel is in D if its center is: the paper's
  Shared  // a voxel counts by its share inside D, so the force does not jump as voxels come and go;
          // a tool thinner than a voxel touches what it reaches into
};

// A part of a tool that cuts better or worse than the rest.
struct CuttingPart {
  PlacedSolid area;  // in the tool's frame
  // Factor of the base vectors of voxels in the area. Where parts overlap, the last one counts.
  double ability = 1;
};

// The collision voxels B are the voxels of either body inside the other's D. The digital normal is
// the mean of their base vectors, each from its own body's C and Gr, times hardness and cutting
// ability.
struct PaperBody {
  // Of the same cloud as the body's SurfaceField; not null. Holds C, Gr and the tissues.
  std::shared_ptr<const BaseVectorField> vectors;
  std::optional<PlacedSolid> area;             // D, in the body's frame; empty: the whole body
  Membership membership = Membership::Shared;  // of the other body's voxels in D
  bool hardness = true;                        // h in (5'); without it (5)
  double ability = 1;                          // cutting ability outside all parts
  std::vector<CuttingPart> parts;
};

// How a PaperBody is made.
struct PaperSettings {
  std::optional<WindowSettings> window;  // C and Gr; empty: sphereWindow() of the cloud
  std::optional<PlacedSolid> area;       // PaperBody's fields
  Membership membership = Membership::Shared;
  bool hardness = true;
  double ability = 1;
  std::vector<CuttingPart> parts;
};

// `tissues`: one for each of the cloud's materials, one for all, or none. Throws
// std::invalid_argument, naming the field, where a setting is not valid, and as BaseVectorField
// does.
PaperBody paperBody(const Cloud& cloud, const TissueTable& tissues,
                    const PaperSettings& settings = {});

// Whether settings state anything, for a body of these tissues: C or Gr, D, membership, abilities,
// or tissues of different hardness. If not, its contacts are those of a body without a PaperBody.
bool states(const PaperSettings& settings, const TissueTable& tissues);

// The cutting ability at a point of the tool's frame; `outside`: of all parts.
double abilityAt(double outside, const std::vector<CuttingPart>& parts, const Vec3& point);

// h of each tissue in (5'): its hardness over that of the first tissue that has one, which is the
// unit; the direction does not depend on it. 0 for a tissue without a hardness beside others. 1 for
// all where none has one or `hardness` is false: (5).
std::vector<double> hardnessOf(const TissueTable& tissues, bool hardness);
void hardnessOf(const TissueTable& tissues, bool hardness, std::vector<double>& h);  // into `h`

}  // namespace cloudcontact
