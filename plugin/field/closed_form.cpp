// A cloud that was cut is not fitted again, so that no tick of a cutting loop waits for a fit.
#include "field/closed_form.h"

#include <mutex>

#include "field/field_data.h"

namespace cloudcontact {

namespace {

constexpr double kQueryError = 0.1;  // [voxels]

}  // namespace

const PlacedSolid* closedForm(const SurfaceField& field) {
  LazyClosedForm& lazy = field.data().lazyForm();
  std::call_once(lazy.once, [&] {
    if (field.data().isRenewed()) return;
    if (auto found = recognizedShape(field, kQueryError * field.cloud().voxelSize()))
      lazy.made = std::make_shared<const PlacedSolid>(std::move(found->placed));
  });
  return lazy.made.get();
}

}  // namespace cloudcontact
