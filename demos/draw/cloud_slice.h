// Slices of a cloud along its grid, and a nearer look at one of them.
#pragma once

#include <array>

#include "draw/contact_scene.h"
#include "draw/cut_view.h"
#include "draw/drawing.h"

namespace cloudcontact::program {

// What is inside, by its material.
Color insideColor(int material);
inline constexpr Color kInterface{43, 108, 176}, kSurface{20, 62, 112};
inline constexpr Color kCenter{190, 18, 60};

// The share of kInterface's ink that a coverage gets.
double inkOf(double coverage);

// What a slice across `axis` shows: which axes run to the right and upward on paper.
struct Slice {
  int axis, right, up;
  const char* caption;
};
inline constexpr std::array<Slice, 3> kSlices = {
    {{2, 0, 1, "slice across z: x to the right, y up"},
     {0, 1, 2, "slice across x: y to the right, z up"},
     {1, 0, 2, "slice across y: x to the right, z up"}}};

// A place worth a nearer look: where a small square of a slice shows the most surface.
struct CloseLook {
  std::size_t slice = 0;  // of kSlices
  Vec3 place = Vec3::Zero();
};

CloseLook closeLookAt(const SurfaceField& field, const Vec3& center);

// All of a slice through `center`, at `scale` px a metre.
CutView sliceView(const SurfaceField& field, const Vec3& center, const Slice& slice,
                  const Rectangle& frame, double scale);
// Its voxels by their coverage and the surface through them.
void addSlice(Drawing& drawing, const PictureBody& body, const Slice& slice, const CutView& view);

// About the place, as far as there is something to see.
CutView closeLookView(const SurfaceField& field, const CloseLook& look, const Rectangle& frame);
// Of the interface voxels, by their part in the slice.
void addBaseVectors(Drawing& drawing, const PictureBody& body, const Slice& slice,
                    const CutView& view);

void addCenterMark(Drawing& drawing, const Point& at);

}  // namespace cloudcontact::program
