// Where to cut a contact, and how near to look.
#pragma once

#include <vector>

#include "draw/contact_scene.h"
#include "draw/cut_view.h"

namespace cloudcontact::program {

// What a close view looks at: a place on the surface and how far the contact reaches around it.
struct Focus {
  int patch = 0;
  Vec3 place = Vec3::Zero();  // world [m]
  double reach = 0;           // [m]
};

// The most loaded patch, at its centre of pressure, or at the sample nearest to it where there is
// none near.
Focus focusOn(const ContactScene& scene, const std::vector<FoundSample>& found);

// The cut that holds the patch's normal and meets the surfaces near the place most squarely.
CutView closeView(const ContactScene& scene, const Focus& focus, const Rectangle& frame);

// The same plane with all of both bodies in the frame.
CutView wholeView(const ContactScene& scene, const CutView& cut, const Rectangle& frame);

}  // namespace cloudcontact::program
