// Slices of a cloud along its grid, and a close-up of one of them.
#pragma once

#include <array>

#include "draw/contact_scene.h"
#include "draw/cut_view.h"
#include "draw/drawing.h"

namespace cloudcontact::program {

// Color of inside voxels, by material.
Color insideColor(int material);
inline constexpr Color kInterface{43, 108, 176}, kSurface{20, 62, 112};
inline constexpr Color kCenter{190, 18, 60};

// Share of kInterface's ink for a coverage.
double inkOf(double coverage);

// A slice across `axis`, with the axes to the right and upward in the drawing.
struct Slice {
  int axis, right, up;
  const char* caption;
};
inline constexpr std::array<Slice, 3> kSlices = {
    {{2, 0, 1, "slice across z: x to the right, y up"},
     {0, 1, 2, "slice across x: y to the right, z up"},
     {1, 0, 2, "slice across y: x to the right, z up"}}};

// The place for the close-up: where a small square of a slice shows the most surface.
struct CloseLook {
  std::size_t slice = 0;  // of kSlices
  Vec3 place = Vec3::Zero();
};

CloseLook closeLookAt(const SurfaceField& field, const Vec3& center);

// The whole slice through `center`, at `scale` [px/m].
CutView sliceView(const SurfaceField& field, const Vec3& center, const Slice& slice,
                  const Rectangle& frame, double scale);
// Adds the voxels shaded by coverage, and the surface.
void addSlice(Drawing& drawing, const PictureBody& body, const Slice& slice, const CutView& view);

// The view around the place, within the body's bounds.
CutView closeLookView(const SurfaceField& field, const CloseLook& look, const Rectangle& frame);
// Adds the surface normals of the interface voxels, projected onto the slice.
void addSurfaceNormals(Drawing& drawing, const PictureBody& body, const Slice& slice,
                       const CutView& view);

void addCenterMark(Drawing& drawing, const Point& at);

}  // namespace cloudcontact::program
