// The close view, from back to front: the voxels of both bodies, their surfaces, the collision
// voxels, the surface normals or base vectors, the patch's normal, the contact points. Then the two
// small views.
#include "draw/contact_drawing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "io/text.h"

namespace cloudcontact::program {

namespace {

constexpr int kShades = 8;
constexpr double kNormalLength = 130;   // of the big arrow [px]
constexpr double kLabelDistance = 235;  // of a body's letter from the contact [px]
constexpr double kLetterSize = 18;
constexpr double kVectorLength = 0.85;  // of a fitted normal's arrow [voxels]

// Groups voxels by material and shade into one element each.
void addVoxels(Drawing& drawing, const std::vector<CutVoxel>& voxels, const Cloud& cloud,
               bool isA) {
  std::map<std::pair<int, int>, std::vector<std::vector<Point>>> alike;
  for (const CutVoxel& v : voxels) {
    const int material = cloud.material(v.voxel.x(), v.voxel.y(), v.voxel.z());
    const auto level = static_cast<int>(std::lround(kShades * v.coverage / 255.0));
    alike[{material, level}].push_back(v.outline);
  }
  for (auto& [look, outlines] : alike) {
    const auto& [material, level] = look;
    drawing.add(Polygons{std::move(outlines),
                         {shade(materialColor(isA, material), double(level) / kShades),
                          Color{255, 255, 255, 0.75}, 0.9}});
  }
}

double areaOf(const std::vector<Point>& ring) {
  double twice = 0;
  for (std::size_t k = 0; k < ring.size(); ++k) {
    const Point &p = ring[k], &q = ring[(k + 1) % ring.size()];
    twice += p.x() * q.y() - p.y() * q.x();
  }
  return std::abs(twice) / 2;
}

// Of `body`: by the paper those in the other's D, else those with a sample in the other body.
// Leaves out slivers of voxels, which would be thick lines only.
void addCollisionVoxels(Drawing& drawing, const PictureBody& body, const PictureBody& other,
                        const CutView& view, const std::vector<CutVoxel>& voxels,
                        const std::vector<FoundSample>& found, const Color& color) {
  if (!body.field) return;
  const double face = std::pow(body.field->cloud().voxelSize() * view.scale, 2);
  std::set<std::tuple<int, int, int>> hit;
  for (const FoundSample& s : found) hit.insert({s.voxel.x(), s.voxel.y(), s.voxel.z()});
  Polygons marked{{}, {std::nullopt, color, 2.2}};
  for (const CutVoxel& v : voxels) {
    const bool isHit = body.paper ? body.paperVoxel(v.voxel, v.center, other).has_value()
                                  : hit.count({v.voxel.x(), v.voxel.y(), v.voxel.z()}) > 0;
    if (isHit && areaOf(v.outline) > 0.2 * face) marked.rings.push_back(v.outline);
  }
  drawing.add(std::move(marked));
}

// Whether the surface crosses a voxel with material or touches its face.
bool onSurface(const Cloud& cloud, const CutVoxel& v) {
  if (v.coverage < 255) return true;
  for (int axis = 0; axis < 3; ++axis)
    for (const int step : {-1, 1}) {
      const Eigen::Vector3i n = v.voxel + step * Eigen::Vector3i::Unit(axis);
      if (cloud.coverage(n.x(), n.y(), n.z()) == 0) return true;
    }
  return false;
}

// An arrow of a voxel [voxels], projected onto the cut; empty for none.
using VoxelArrow = std::function<std::optional<Point>(const CutVoxel&)>;

// The fitted outward normal of an interface voxel.
VoxelArrow fittedNormals(const PictureBody& body, const CutView& view) {
  return [&](const CutVoxel& v) -> std::optional<Point> {
    if (!onSurface(body.field->cloud(), v)) return {};
    const std::optional<FieldPoint> point = body.at(v.center);
    if (!point) return {};
    const Point along = view.direction(point->normal);
    if (along.norm() < 0.4) return {};  // points at the viewer: too short to show
    return Point(kVectorLength * along);
  };
}

// The base vector of a collision voxel, in its true length.
VoxelArrow baseVectors(const PictureBody& body, const PictureBody& other, const CutView& view) {
  return [&](const CutVoxel& v) -> std::optional<Point> {
    const auto found = body.paperVoxel(v.voxel, v.center, other);
    if (!found) return {};
    const Point along = view.direction(found->baseVector) / body.field->cloud().voxelSize();
    if (along.norm() < 0.1) return {};
    return along;
  };
}

// Of several layers of the grid in the cut only the nearest is drawn.
void addArrows(Drawing& drawing, const PictureBody& body, std::vector<CutVoxel> voxels,
               const CutView& view, const Focus& focus, const Color& color,
               const VoxelArrow& arrowOf) {
  const double h = body.field->cloud().voxelSize();
  const double near = std::max(5 * h, 1.25 * focus.reach);
  const auto depth = [&](const CutVoxel& v) { return std::abs(view.distance(v.center)); };
  std::stable_sort(voxels.begin(), voxels.end(), [&](const CutVoxel& p, const CutVoxel& q) {
    return depth(p) < depth(q) - 1e-6 * h;
  });
  std::vector<Point> starts;
  for (const CutVoxel& v : voxels) {
    if ((v.center - focus.place).norm() > near) continue;
    const std::optional<Point> along = arrowOf(v);
    if (!along) continue;
    const Point start = view.toPaper(v.center);
    const auto close = [&](const Point& p) { return (p - start).norm() < 0.7 * h * view.scale; };
    if (std::any_of(starts.begin(), starts.end(), close)) continue;
    starts.push_back(start);
    drawing.add(arrow(start, start + h * view.scale * *along, color, kVectorWidth));
  }
}

void addVectors(Drawing& drawing, const PictureBody& body, const PictureBody& other,
                const std::vector<CutVoxel>& voxels, const CutView& view, const Focus& focus,
                const Color& color) {
  if (!body.field) return;
  addArrows(drawing, body, voxels, view, focus, color,
            body.paper ? baseVectors(body, other, view) : fittedNormals(body, view));
}

void addBody(Drawing& drawing, const PictureBody& body, const CutView& view, bool isA,
             const std::vector<CutVoxel>& voxels) {
  if (body.field)
    addVoxels(drawing, voxels, body.field->cloud(), isA);
  else
    drawing.add(Polygons{materialStripes(body, view, 2, 0),
                         {shade(materialColor(isA, 0), 1), std::nullopt, 0}});
}

// Only points in the cut; the view of the patch shows the others.
void addPoints(Drawing& drawing, const ContactScene& scene, const CutView& view) {
  for (const ContactPoint& p : scene.result.points)
    if (std::abs(view.distance(p.position)) < 1.5 * scene.voxel)
      addPoint(drawing, view.toPaper(p.position), 5);
}

void addPatchNormal(Drawing& drawing, const ContactScene& scene, const CutView& view,
                    const Focus& focus) {
  const Vec3 normal = scene.result.patches[static_cast<std::size_t>(focus.patch)].normal;
  const Point start = view.toPaper(focus.place);
  const Point along = view.direction(normal).normalized();
  const Point end = start + kNormalLength * along;
  Polygons rim = arrow(start, end, kContactRed, kNormalWidth);
  rim.paint.stroke = kPaperWhite;
  rim.paint.width = 4;
  drawing.add(rim);
  drawing.add(arrow(start, end, kContactRed, kNormalWidth));
  const Point label = start + (kNormalLength + 14) * along + Point(0, 5);
  const bool toLeft = along.x() < -0.2;
  const Align align = std::abs(along.x()) < 0.2 ? Align::Middle
                      : toLeft                  ? Align::Right
                                                : Align::Left;
  drawing.add(Text{label, normalName(scene.byPaper()), 16, kContactRed, align, true, true});
}

// A body's letter, with the material's name if there are several, placed inside that material.
void addBodyLabel(Drawing& drawing, const PictureBody& body, const PictureBody& other,
                  const CutView& view, const std::string& words, int material, const Color& color) {
  const Point half(widthOf(words, kLetterSize, true) / 2, 12);
  const Point center = view.frame.center();
  double best = -kWidth;
  Point place = center;
  for (double y = view.frame.low.y() + 30; y < view.frame.high.y() - 60; y += 15)
    for (double x = view.frame.low.x() + half.x() + 12; x < view.frame.high.x() - half.x() - 12;
         x += 20) {
      const auto only = [&](const Point& p) {
        const Vec3 world = view.toWorld(p);
        return body.coverageAt(world) == 1 && body.materialAt(world) == material &&
               other.coverageAt(world) == 0;
      };
      bool clear = true;
      for (const double sx : {-1.0, -0.5, 0.0, 0.5, 1.0})
        for (const double sy : {-1.0, 1.0}) clear &= only({x + sx * half.x(), y + sy * half.y()});
      // Near the contact, but clear of its marks.
      const double score = -std::abs((Point(x, y) - center).norm() - kLabelDistance);
      if (!clear || score <= best) continue;
      best = score;
      place = {x, y};
    }
  if (best > -kWidth)
    drawing.add(Text{place + Point(0, 6), words, kLetterSize, color, Align::Middle, true, true});
}

void addBodyLabels(Drawing& drawing, const PictureBody& body, const PictureBody& other,
                   const CutView& view, const std::string& letter, const Color& color) {
  if (!body.field)
    return addBodyLabel(drawing, body, other, view, letter + ", a half-space without voxels", 0,
                        color);
  const std::vector<std::string>& materials = body.field->cloud().materials();
  if (materials.empty()) return addBodyLabel(drawing, body, other, view, letter, 0, color);
  for (std::size_t m = 0; m < materials.size(); ++m)
    addBodyLabel(drawing, body, other, view, letter + ", " + printable(materials[m]),
                 static_cast<int>(m), color);
}

// Samples as small squares; draws a subset of thousands.
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

// Labels the line through `center`, near the frame's lower edge, or the left one for a flat line.
void addCutLabel(Drawing& drawing, const Rectangle& frame, const Point& center,
                 const Point& along) {
  const bool steep = std::abs(along.y()) > 0.4;
  const double reach = steep ? (frame.high.y() - 10 - center.y()) / along.y()
                             : (frame.low.x() + 8 - center.x()) / along.x();
  const Point at = center + reach * along + (steep ? Point(7, 0) : Point(0, -6));
  drawing.add(Text{at, "this cut", kSmallText, kFaintInk, Align::Left, false, true});
}

}  // namespace

const char* normalName(bool byPaper) {
  return byPaper ? "digital normal" : "contact normal";
}

Color materialColor(bool isA, int material) {
  static constexpr Color kOfA[] = {kBodyA, {38, 150, 136}, {124, 92, 196}, {84, 104, 128}};
  static constexpr Color kOfB[] = {kBodyB, {196, 160, 16}, {168, 68, 42}, {138, 109, 59}};
  return (isA ? kOfA : kOfB)[material % 4];
}

Color shade(Color color, double coverage) {
  color.alpha = 0.08 + 0.5 * coverage;
  return color;
}

void addPoint(Drawing& drawing, const Point& at, double radius) {
  drawing.add(Circle{at, radius, {kPaperWhite, kContactRed, 2.4}});
}

void addCloseView(Drawing& drawing, const ContactScene& scene, const Marks& marks,
                  const CutView& view) {
  const auto cut = [&](const PictureBody& body) {
    return body.field ? cutVoxels(body.field->cloud(), body.pose, view) : std::vector<CutVoxel>();
  };
  const std::vector<CutVoxel> a = cut(scene.a), b = cut(scene.b);
  const auto group = [&](const char* name, auto draw) {
    drawing.add(GroupBegin{name, view.frame});
    draw();
    drawing.add(GroupEnd{});
  };
  group("body-a", [&] { addBody(drawing, scene.a, view, true, a); });
  group("body-b", [&] { addBody(drawing, scene.b, view, false, b); });
  const double spacing = 0.3 * scene.voxel * view.scale;
  group("surfaces", [&] {
    drawing.add(Polygons{surfaceLines(scene.a, view, spacing), {{}, kDarkA, 1.8}, false});
    drawing.add(Polygons{surfaceLines(scene.b, view, spacing), {{}, kDarkB, 1.8}, false});
  });
  if (!marks.touching) return;
  group("collision-voxels", [&] {
    addCollisionVoxels(drawing, scene.a, scene.b, view, a, marks.inA, kDarkA);
    addCollisionVoxels(drawing, scene.b, scene.a, view, b, marks.inB, kDarkB);
  });
  group(scene.byPaper() ? "base-vectors" : "fitted-normals", [&] {
    addVectors(drawing, scene.a, scene.b, a, view, marks.focus, kDarkA);
    addVectors(drawing, scene.b, scene.a, b, view, marks.focus, kDarkB);
  });
  group(scene.byPaper() ? "digital-normal" : "contact-normal",
        [&] { addPatchNormal(drawing, scene, view, marks.focus); });
  group("contact-points", [&] { addPoints(drawing, scene, view); });
  group("names", [&] {
    addBodyLabels(drawing, scene.a, scene.b, view, "A", kDarkA);
    addBodyLabels(drawing, scene.b, scene.a, view, "B", kDarkB);
  });
}

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
