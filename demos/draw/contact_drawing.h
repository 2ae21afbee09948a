// The parts of a contact's picture: the close view of the cut, the whole bodies, the patch face on.
#pragma once

#include <vector>

#include "draw/contact_view.h"
#include "draw/cut_view.h"
#include "draw/drawing.h"
#include "draw/picture_elements.h"

namespace cloudcontact::program {

// A is blue, B orange, contacts red.
inline constexpr Color kBodyA{43, 108, 176}, kBodyB{221, 122, 30};
// Colors of the first material; materialColor() has those of the others.
Color materialColor(bool isA, int material);
inline constexpr Color kDarkA{20, 62, 112}, kDarkB{138, 66, 6};
inline constexpr Color kContactRed{190, 18, 60};
inline constexpr double kNormalWidth = 8, kVectorWidth = 2;  // of the arrows' shafts [px]

// The results that a picture marks.
struct Marks {
  std::vector<FoundSample> inA, inB;  // samples of A that lie in B, and of B in A
  Focus focus;
  bool touching = false;
};

// What a patch's normal is called.
const char* normalName(bool byPaper);
// A body's color, paler with less coverage.
Color shade(Color color, double coverage);
void addPoint(Drawing& drawing, const Point& at, double radius);

void addCloseView(Drawing& drawing, const ContactScene& scene, const Marks& marks,
                  const CutView& view);
// Both bodies whole, in the same cut; a box marks the view `close`.
void addWholeView(Drawing& drawing, const ContactScene& scene, const CutView& close,
                  const Rectangle& frame);
// The patch seen from B: its samples, its points, and the line of the cut.
void addPatchFace(Drawing& drawing, const ContactScene& scene, const Marks& marks,
                  const CutView& close, const Rectangle& frame);

}  // namespace cloudcontact::program
