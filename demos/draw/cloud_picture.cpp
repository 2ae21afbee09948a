// Lays out the picture of a cloud: a view from outside, three slices through the center of mass,
// figures and a key.
#include "draw/cloud_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

#include "draw/cloud_slice.h"
#include "draw/isometric.h"
#include "draw/picture_elements.h"
#include "io/text.h"

namespace cloudcontact::program {

namespace {

constexpr double kHeight = 796;
const Rectangle kOutside{{kMargin, 82}, {424, 366}};
const std::array<Rectangle, 3> kFrames = {
    {{{436, 82}, {836, 366}}, {{kMargin, 378}, {424, 662}}, {{436, 378}, {836, 662}}}};
const Rectangle kLook{{864, 304}, {kWidth - kMargin, 488}};
const Rectangle kSide{{864, 82}, {kWidth - kMargin, 662}};
constexpr double kColors = 500,
                 kBall = 598;  // heights of the heading of the colors and of their ball

// The scale of all slices, at which the largest fills its frame.
double sliceScale(const SurfaceField& field) {
  const Vec3 size = 1.16 * field.bounds().sizes();
  const Point room = belowCaption(kFrames[0]).size();
  double scale = room.x() / size[kSlices[0].right];
  for (const Slice& slice : kSlices)
    scale = std::min({scale, room.x() / size[slice.right], room.y() / size[slice.up]});
  return scale;
}

void addSlices(Drawing& drawing, const PictureBody& body, const Vec3& center) {
  const SurfaceField& field = *body.field;
  const double scale = sliceScale(field);
  const CloseLook look = closeLookAt(field, center);
  const CutView near = closeLookView(field, look, belowCaption(kLook));
  for (std::size_t k = 0; k < kSlices.size(); ++k) {
    const Slice& slice = kSlices[k];
    const CutView view = sliceView(field, center, slice, belowCaption(kFrames[k]), scale);
    drawing.add(GroupBegin{std::string("slice-") + "xyz"[slice.axis], view.frame});
    addSlice(drawing, body, slice, view);
    addCenterMark(drawing, view.toPaper(center));
    if (k == look.slice) {
      const Point half = near.frame.size() / 2 * view.scale / near.scale;
      const Point at = view.toPaper(near.origin);
      drawing.add(Polygons{{ringOf({at - half, at + half})}, {std::nullopt, kInk, 2}});
    }
    drawing.add(GroupEnd{});
    addCaption(drawing, kFrames[k], slice.caption, scale);
    addFrame(drawing, kFrames[k]);
  }
  drawing.add(GroupBegin{"close-look", near.frame});
  addSlice(drawing, body, kSlices[look.slice], near);
  addSurfaceNormals(drawing, body, kSlices[look.slice], near);
  drawing.add(GroupEnd{});
  addCaption(drawing, kLook, "close-up of the box", near.scale);
  addFrame(drawing, kLook);
}

void addFigures(Drawing& drawing, const SurfaceField& field, const MassProperties& mass) {
  const Cloud& cloud = field.cloud();
  const VoxelCounts counts = cloud.counts();
  const Vec3 size = field.bounds().sizes();
  Table table(drawing, kSide.low, kSide.size().x());
  table.heading("The cloud");
  table.row("voxel", lengthText(cloud.voxelSize()));
  const std::string times = " \u00d7 ";
  table.row("size",
            lengthText(size.x()) + times + lengthText(size.y()) + times + lengthText(size.z()));
  table.row("volume", volumeText(mass.volume));
  table.row("inside voxels", countText(counts.inside));
  table.row("interface voxels", countText(counts.interface));
  table.row("voxels near the surface", countText(field.bandVoxels()));
  if (!cloud.materials().empty()) table.row("materials", countText(cloud.materials().size()));
  table.row("surface samples", countText(field.sampleCount()));
}

void addKey(Drawing& drawing, const std::vector<std::string>& materials) {
  const auto entry = [&](int k, const char* term, const char* meaning) {
    const Point at(kMargin + 26 + 390 * (k % 3), 700 + 54 * (k / 3));
    addKeyText(drawing, at + Point(34, -4), term, meaning);
    return at;
  };
  const auto square = [&](const Point& at, double x, const Color& color) {
    const Point low = at + Point(x, -8);
    drawing.add(Polygons{{ringOf({low, low + Point(15, 15)})}, {color, kPaperWhite, 1}});
  };
  drawing.add(GroupBegin{"key", {}});
  Point at = entry(0, "Interface voxels", "darker with more material");
  for (int k = 0; k < 3; ++k) {
    Color color = kInterface;
    color.alpha = inkOf((k + 0.5) / 3);
    square(at, -25 + 16 * k, color);
  }
  constexpr std::size_t kNamed = 3;  // limited by the key's colors and space
  std::string names;
  for (std::size_t m = 0; m < std::min(kNamed, materials.size()); ++m)
    names += (m == 0 ? "" : ", ") + shortName(printable(materials[m]), 16);
  if (materials.size() > kNamed) names += " ...";
  at = entry(1, "Inside voxels", names.empty() ? "all material" : names.c_str());
  const int shown = std::clamp(static_cast<int>(materials.size()), 1, 3);
  for (int k = 0; k < shown; ++k) square(at, shown == 1 ? 0 : -25 + 16 * k, insideColor(k));
  at = entry(2, "Surface", "fitted to the coverage, finer than a voxel");
  drawing.add(line(at + Point(-24, 0), at + Point(20, 0), kSurface, 1.5));
  at = entry(3, "Surface normals", "out of the material, one per surface voxel");
  drawing.add(arrow(at + Point(-2, 10), at + Point(-2, -14), kSurface, 2));
  addCenterMark(drawing, entry(4, "Center of mass", "all slices contain it"));
  at = entry(5, "Box", "shown in the close-up");
  drawing.add(Polygons{{ringOf({at - Point(14, 8), at + Point(14, 8)})}, {std::nullopt, kInk, 2}});
  drawing.add(GroupEnd{});
}

void addOutside(Drawing& drawing, const SurfaceField& field) {
  const Rectangle inner = belowCaption(kOutside);
  drawing.add(GroupBegin{"outside", inner});
  const double alongAxes = addVoxelsFromOutside(drawing, field, inner);
  drawing.add(GroupEnd{});
  addCaption(drawing, kOutside, "from outside, colored by surface normals", alongAxes);
  addFrame(drawing, kOutside);
  drawing.add(GroupBegin{"colors", {}});
  Table heading(drawing, {kSide.low.x(), kColors}, kSide.size().x());
  heading.heading("Colors: direction of the surface normal");
  addNormalBall(drawing, {kSide.center().x(), kBall}, 36);
  drawing.add(GroupEnd{});
}

}  // namespace

Drawing cloudPicture(const std::string& name, std::shared_ptr<const SurfaceField> field) {
  const MassProperties mass = field->cloud().massProperties();
  Drawing drawing{kWidth, kHeight, {}, {}};
  addTitle(drawing, shortName(name) + " as a digital cloud",
           "Each voxel holds how much of it is material; near the surface it also knows which way "
           "is out.");
  addOutside(drawing, *field);
  const PictureBody body{name, field, {}, {}};
  addSlices(drawing, body, mass.centerOfMass);
  drawing.add(GroupBegin{"figures", {}});
  addFigures(drawing, *field, mass);
  drawing.add(GroupEnd{});
  addKey(drawing, field->cloud().materials());
  return drawing;
}

}  // namespace cloudcontact::program
