// The two small views beside the cut: where it is, and the patch from its front.
#include <algorithm>
#include <cmath>
#include <utility>

#include "draw/contact_drawing.h"

namespace cloudcontact::program {

namespace {

// Samples as small squares; where there are thousands, some stand for all.
Polygons dots(const std::vector<FoundSample>& samples, int patch, const CutView& view,
              const Color& color) {
  constexpr std::size_t kMostDots = 500;
  Polygons squares{{}, {color, std::nullopt, 0}};
  const std::size_t stride = samples.size() / kMostDots + 1;
  const Point half(1.2, 1.2);
  for (std::size_t k = 0; k < samples.size(); k += stride) {
    const Point at = view.toPaper(samples[k].position);
    if (samples[k].patch == patch) squares.rings.push_back(ringOf({at - half, at + half}));
  }
  return squares;
}

// Beside the line through `center`, near the frame's lower edge, or its left one where it lies
// flat.
void addCutLabel(Drawing& drawing, const Rectangle& frame, const Point& center,
                 const Point& along) {
  const bool steep = std::abs(along.y()) > 0.4;
  const double reach = steep ? (frame.high.y() - 10 - center.y()) / along.y()
                             : (frame.low.x() + 8 - center.x()) / along.x();
  const Point at = center + reach * along + (steep ? Point(7, 0) : Point(0, -6));
  drawing.add(Text{at, "this cut", kSmallText, kFaintInk, Align::Left, false, true});
}

}  // namespace

void addWholeView(Drawing& drawing, const ContactScene& scene, const CutView& close,
                  const Rectangle& frame) {
  const CutView view = wholeView(scene, close, belowCaption(frame));
  drawing.add(GroupBegin{"overview", view.frame});
  for (const auto& [body, isA] : {std::pair(&scene.a, true), std::pair(&scene.b, false)}) {
    const int materials =
        body->field ? static_cast<int>(body->field->cloud().materials().size()) : 0;
    for (int m = 0; m < std::max(1, materials); ++m)
      drawing.add(Polygons{materialStripes(*body, view, 1.5, m),
                           {shade(materialColor(isA, m), 1), std::nullopt, 0}});
  }
  const Point middle = view.toPaper(close.origin);
  const Point half = close.frame.size() / 2 * view.scale / close.scale;
  drawing.add(Polygons{{ringOf({middle - half, middle + half})}, {std::nullopt, kInk, 2}});
  drawing.add(GroupEnd{});
  addCaption(drawing, frame, "the whole bodies, same cut", view.scale);
  addFrame(drawing, frame);
}

void addPatchFace(Drawing& drawing, const ContactScene& scene, const Marks& marks,
                  const CutView& close, const Rectangle& frame) {
  const int patch = marks.focus.patch;
  const Vec3 normal = scene.result.patches[static_cast<std::size_t>(patch)].normal;
  const Rectangle inner = belowCaption(frame);
  CutView view = viewAcross(marks.focus.place, normal, inner, 1);
  Eigen::AlignedBox2d box;
  for (const auto* samples : {&marks.inA, &marks.inB})
    for (const FoundSample& s : *samples)
      if (s.patch == patch) box.extend(view.toPaper(s.position) - inner.center());
  for (const ContactPoint& p : scene.result.points)
    if (p.patch == patch) box.extend(view.toPaper(p.position) - inner.center());
  const Point least = Point::Constant(2 * scene.voxel);
  const Point size = 1.25 * (box.isEmpty() ? least : Point(box.sizes().cwiseMax(least)));
  const Point middle = box.isEmpty() ? Point(0, 0) : Point(box.center());
  view.origin += middle.x() * view.right - middle.y() * view.up;
  view.scale = std::min(inner.size().x() / size.x(), inner.size().y() / size.y());
  drawing.add(GroupBegin{"patch", inner});
  const Point cut = view.direction(normal.cross(close.across())).normalized() * kWidth;
  const Point center = view.toPaper(close.origin);
  drawing.add(line(center - cut, center + cut, kRule, 2));
  addCutLabel(drawing, inner, center, cut.normalized());
  drawing.add(dots(marks.inA, patch, view, kBodyA));
  drawing.add(dots(marks.inB, patch, view, kBodyB));
  for (const ContactPoint& p : scene.result.points)
    if (p.patch == patch) addPoint(drawing, view.toPaper(p.position), 4);
  drawing.add(GroupEnd{});
  addCaption(drawing, frame, "the patch's samples, face on", view.scale);
  addFrame(drawing, frame);
}

}  // namespace cloudcontact::program
