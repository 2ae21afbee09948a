// Chooses the cut through a contact and its scale.
#pragma once

#include <vector>

#include "draw/contact_scene.h"
#include "draw/cut_view.h"

namespace cloudcontact::program {

// The target of a close view: a place on the surface and the extent of the contact around it.
struct Focus {
  int patch = 0;
  Vec3 place = Vec3::Zero();  // world [m]
  double reach = 0;           // [m]
};

// The most loaded patch at its center of pressure, or at the nearest sample if the center is far
// from all.
Focus focusOn(const ContactScene& scene, const std::vector<FoundSample>& found);

// The cut that contains the patch's normal and is most perpendicular to the surfaces near the
// place.
CutView closeView(const ContactScene& scene, const Focus& focus, const Rectangle& frame);

// The same plane with both bodies whole in the frame.
CutView wholeView(const ContactScene& scene, const CutView& cut, const Rectangle& frame);

}  // namespace cloudcontact::program
