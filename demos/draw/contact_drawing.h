// The parts of a contact's picture: the cut from near, the whole bodies, the patch face on.
#pragma once

#include <vector>

#include "draw/contact_view.h"
#include "draw/cut_view.h"
#include "draw/drawing.h"
#include "draw/picture_elements.h"

namespace cloudcontact::program {

// A is blue, B orange, what the contact makes of them red.
inline constexpr Color kBodyA{43, 108, 176}, kBodyB{221, 122, 30};
// Of their first material; materialColor() tells the others apart from it.
Color materialColor(bool isA, int material);
inline constexpr Color kDarkA{20, 62, 112}, kDarkB{138, 66, 6};
inline constexpr Color kContactRed{190, 18, 60};
inline constexpr double kNormalWidth = 8, kVectorWidth = 2;  // of the arrows' shafts [px]

// What was found, as far as a picture marks it.
struct Marks {
  std::vector<FoundSample> inA, inB;  // samples of A that lie in B, and of B in A
  Focus focus;
  bool touching = false;
};

// A body's colour as pale as its voxel is empty.
Color shade(Color color, double coverage);
void addPoint(Drawing& drawing, const Point& at, double radius);

void addCloseView(Drawing& drawing, const ContactScene& scene, const Marks& marks,
                  const CutView& view);
// All of both bodies in the same cut; a box shows what `close` is a view of.
void addWholeView(Drawing& drawing, const ContactScene& scene, const CutView& close,
                  const Rectangle& frame);
// The patch as B sees it: the samples that made it, its points, and where the cut runs.
void addPatchFace(Drawing& drawing, const ContactScene& scene, const Marks& marks,
                  const CutView& close, const Rectangle& frame);

}  // namespace cloudcontact::program
