// ShapeContact: the contact of two shapes given by formulas, as ContactFinder gives that of clouds
// (docs/engine.md, "Shapes").
#pragma once

#include <cloudcontact/contact/contact.h>

#include "contact/contact_builder.h"
#include "contact/press_direction.h"
#include "contact/pressed_area.h"

namespace cloudcontact {

// Finds the contacts of one pair, step by step. It keeps its result and the points' IDs between
// calls. After the first call it allocates nothing.
class ShapeContact {
 public:
  // Whether find() takes this pair and law: shapes that are simple (isSimple), not both
  // half-spaces, and one spring a pair. Not Foundation, whose force goes by the area of a dented
  // surface.
  static bool takes(const Solid& a, const Solid& b, const ContactSettings& settings);

  // The contact of two bodies whose `shape` is set: one patch of one, two or four points. False if
  // the bodies are too deep in each other for closed forms (pressDirection). `voxel` [m]: the
  // pair's.
  bool search(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
              double voxel);
  // Gives the points their IDs and returns the result of the last search.
  const ContactResult& withIds();
  PatchIds& ids() { return ids_; }

 private:
  struct Pair {
    const ContactBody &a, &b;
    const ContactSettings& settings;
    PlacedConvex inA, inB;  // about A's position
  };
  bool tryAlong(const Pair& pair, const PressDirection& press, bool mustBeBroad);
  void add(const PressedArea& area, const Pair& pair, const Eigen::Matrix3d& axes,
           const Vec3& origin);

  ContactResult result_;
  std::vector<PatchIds::Patch> patches_;
  PatchIds ids_;
  double voxel_ = 0;
};

}  // namespace cloudcontact
