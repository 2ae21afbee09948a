// `contact --picture`: the method made visible in a cut through a contact.
#pragma once

#include "draw/contact_scene.h"
#include "draw/drawing.h"

namespace cloudcontact::program {

// The cut through the most loaded patch, along its digital normal, turned about it so that the
// surfaces are met squarely; with the figures, a key, and the whole bodies in small. Bodies that do
// not touch are shown whole.
Drawing contactPicture(const ContactScene& scene);

}  // namespace cloudcontact::program
