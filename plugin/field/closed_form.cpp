// A cloud that was cut is not fitted again, so that no tick of a cutting loop waits for a fit.
#include "field/closed_form.h"

#include <mutex>

#include "field/field_data.h"

namespace cloudcontact {

const RecognizedShape* closedForm(const SurfaceField& field) {
  LazyClosedForm& lazy = field.data().lazyForm();
  std::call_once(lazy.once, [&] {
    if (field.data().isRenewed()) return;
    if (auto found = recognizedShape(field, kCloudError * field.cloud().voxelSize()))
      lazy.made = std::make_shared<const RecognizedShape>(std::move(*found));
  });
  return lazy.made.get();
}

}  // namespace cloudcontact
