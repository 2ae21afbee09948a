// The picture of `contact --picture`: a cut through a contact that shows the method.
#pragma once

#include "draw/contact_scene.h"
#include "draw/drawing.h"

namespace cloudcontact::program {

// Shows a cut through the most loaded patch that contains its normal and is as
// perpendicular to the surfaces as possible, with figures, a key, and the whole bodies. Bodies that
// do not touch are shown whole.
Drawing contactPicture(const ContactScene& scene);

}  // namespace cloudcontact::program
