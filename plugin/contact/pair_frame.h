// Where the two bodies of a pair are: the frame of the query, and the maps of samples into it and
// into the other body.
#pragma once

#include <cloudcontact/contact/contact.h>

#include "contact/hit_columns.h"
#include "kernels/contact/look_up.h"
#include "kernels/contact/shape_depth.h"

#include <optional>

namespace cloudcontact {

// The frame that hits, bins and patches are in: that of one of the two bodies.
struct PairFrame {
  Side body = kA;    // the frame body, which has a field
  Pose pose;         // its pose
  double voxel = 0;  // the larger of the two voxels [m]
};

// The frame does not depend on which body is called A: it is that of the body with fewer samples
// or, if both have as many, of the one that sees the other on the greater side.
PairFrame frameOf(const ContactBody& a, const ContactBody& b);
// The maps of the samples of `own`, a field, into the frame and into the other body.
CcWay wayOf(const ContactBody& own, const ContactBody& other, const PairFrame& frame);
// The pose of a cloud's grid in its body [m].
Pose gridPose(const Cloud& cloud);
// From the grid of the samples of `own`, in meters, into the frame of `other`, a shape.
Pose toShapeOf(const ContactBody& own, const ContactBody& other);
// A shape that is a plain solid, as samples of a cloud with these voxels [m] see it.
std::optional<CcShape> plainShape(const Solid& shape, const Pose& toShape, double voxel);
// ContactSettings::margin [m], as far as the bodies are to be seen: a plane without a limit, others
// to the width of a field's band. A plane faces the same way from everywhere; the nearest place of
// another shape is not where a body that passes by would touch it. `voxel`: of the pair's frame
// [m].
double marginOf(const ContactBody& a, const ContactBody& b, double voxel, double margin);

// True only if the bodies' boxes, each aligned with its body's axes, are more than `reach` [m]
// apart.
bool farApart(const ContactBody& a, const ContactBody& b, double reach);

}  // namespace cloudcontact
