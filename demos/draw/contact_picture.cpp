// Lays out the picture of a contact: the cut, figures and small views on the right, a key below.
#include "draw/contact_picture.h"

#include <string>
#include <tuple>
#include <utility>

#include "draw/contact_drawing.h"

namespace cloudcontact::program {

namespace {

constexpr double kHeight = 812;
const Rectangle kMain{{kMargin, 82}, {836, 662}};
const Rectangle kWhole{{864, 330}, {kWidth - kMargin, 490}};  // all of both bodies
const Rectangle kFace{{864, 502}, {kWidth - kMargin, 662}};   // the patch from its front

void addPatchFigures(Table& table, const ContactScene& scene, int index) {
  const ContactResult& result = scene.result;
  const Patch& patch = result.patches[static_cast<std::size_t>(index)];
  const int patches = static_cast<int>(result.patches.size());
  const double force = forceOf(result, index);
  double all = 0;
  for (int k = 0; k < patches; ++k) all += forceOf(result, k);
  table.space(14);
  table.heading(patches > 1 ? "The patch in the picture" : "Its one patch");
  table.row(normalName(scene.byPaper()), tripleText(patch.normal));
  table.row("depth d",
            lengthText(patch.depth) + " = " + numberText(patch.depth / scene.voxel) + " voxels");
  const bool share = patches > 1 && all > 0;
  table.row("force k d",
            forceText(force) + (share ? ", " + numberText(100 * force / all) + " % of all" : ""));
}

void addFigures(Drawing& drawing, const ContactScene& scene, const Marks& marks) {
  const double width = kWhole.size().x();
  Table table(drawing, {kWhole.low.x(), kMain.low.y()}, width);
  const ContactResult& result = scene.result;
  const Wrench onB = wrenchOnB(result, Motion{}, scene.motionB);
  table.heading("The contact");
  table.row("force on B", forceText(onB.force.norm()));
  if (onB.force.norm() > 0) table.row("its direction", tripleText(onB.force.normalized()));
  table.row("patches, points",
            countText(result.patches.size()) + ", " + countText(result.points.size()));
  table.row("samples inside the other", countText(result.samples));
  table.row("voxel", lengthText(scene.voxel));
  if (marks.touching) addPatchFigures(table, scene, marks.focus.patch);
}

struct KeyEntry {
  const char* term;
  std::string meaning;
  void (*symbol)(Drawing&, const Point&);
};

void voxelSymbol(Drawing& drawing, const Point& at) {
  for (int k = 0; k < 3; ++k)
    for (const auto& [color, y] : {std::pair(kBodyA, -15.0), std::pair(kBodyB, 0.0)}) {
      const Point low = at + Point(-24 + 15 * k, y);
      drawing.add(Polygons{{ringOf({low, low + Point(14, 14)})},
                           {shade(color, (k + 1) / 3.0), kPaperWhite, 1}});
    }
}
void surfaceSymbol(Drawing& drawing, const Point& at) {
  drawing.add(line(at + Point(-24, -6), at + Point(20, -6), kDarkA, 1.8));
  drawing.add(line(at + Point(-24, 4), at + Point(20, 4), kDarkB, 1.8));
}
void collisionSymbol(Drawing& drawing, const Point& at) {
  for (const auto& [color, dark, x] :
       {std::tuple(kBodyA, kDarkA, -24.0), std::tuple(kBodyB, kDarkB, 0.0)}) {
    const Point low = at + Point(x, -10);
    drawing.add(Polygons{{ringOf({low, low + Point(18, 18)})}, {shade(color, 0.6), dark, 2.2}});
  }
}
void vectorSymbol(Drawing& drawing, const Point& at) {
  drawing.add(arrow(at + Point(-14, 8), at + Point(-14, -16), kDarkA, kVectorWidth));
  drawing.add(arrow(at + Point(8, -16), at + Point(8, 8), kDarkB, kVectorWidth));
}
void normalSymbol(Drawing& drawing, const Point& at) {
  drawing.add(arrow(at + Point(-24, 0), at + Point(22, 0), kContactRed, kNormalWidth));
}
void pointSymbol(Drawing& drawing, const Point& at) {
  for (const double x : {-18.0, -1.0, 16.0}) addPoint(drawing, at + Point(x, -2), 5);
}

void addKey(Drawing& drawing, bool byPaper) {
  const KeyEntry vectors =
      byPaper
          ? KeyEntry{"Base vectors", "of collision voxels: Gr - Gc, in their length", vectorSymbol}
          : KeyEntry{"Surface normals", "out of the material, one per surface voxel", vectorSymbol};
  const KeyEntry collision = {
      "Collision voxels",
      byPaper ? "inside the other's detection area D" : "their surface lies inside the other body",
      collisionSymbol};
  const KeyEntry normal =
      byPaper ? KeyEntry{"Digital normal", "the mean of the patch's base vectors", normalSymbol}
              : KeyEntry{"Contact normal", "base vectors of the surface, summed by area and depth",
                         normalSymbol};
  const KeyEntry entries[] = {
      {"Voxels of A and B", "darker with more material", voxelSymbol},
      {"Surface", "fitted to the coverage, finer than a voxel", surfaceSymbol},
      vectors,
      collision,
      normal,
      {"Contact points", "at most four a patch, with all its force", pointSymbol}};
  drawing.add(GroupBegin{"key", {}});
  for (int k = 0; k < 6; ++k) {
    const Point at(kMargin + 26 + 390 * (k % 3), 704 + 56 * (k / 3));
    entries[k].symbol(drawing, at);
    addKeyText(drawing, at + Point(34, -4), entries[k].term, entries[k].meaning);
  }
  drawing.add(GroupEnd{});
}

std::string subtitle(const ContactScene& scene, const Marks& marks) {
  if (!marks.touching) return "The bodies do not touch.";
  const std::size_t patches = scene.result.patches.size();
  return (patches > 1 ? "A cut through the most loaded of its " + std::to_string(patches) +
                            " patches, number " + std::to_string(marks.focus.patch)
                      : std::string("A cut through the contact")) +
         ", along its " + normalName(scene.byPaper()) +
         "; it pushes B that way with the force k d.";
}

// Without a contact, the cut is a plane through the middles of both bodies.
CutView apartView(const ContactScene& scene) {
  const Vec3 middle = scene.b.pose.position - scene.a.pose.position;
  Vec3 across = Vec3::UnitZ().cross(middle);
  across = across.norm() > 1e-9 * middle.norm() ? across.normalized() : Vec3::UnitY();
  // Off the planes of the grid, as in closeView.
  const Vec3 origin = scene.b.pose.position + 1e-3 * scene.voxel * across;
  const CutView view = viewAcross(origin, across, kMain, 0);
  return wholeView(scene, view, kMain);
}

}  // namespace

Drawing contactPicture(const ContactScene& scene) {
  Marks marks;
  marks.touching = !scene.result.patches.empty();
  if (marks.touching) {
    marks.inA = samplesIn(scene.a, scene.b, scene.result.points);
    marks.inB = samplesIn(scene.b, scene.a, scene.result.points);
    std::vector<FoundSample> all = marks.inA;
    all.insert(all.end(), marks.inB.begin(), marks.inB.end());
    marks.focus = focusOn(scene, all);
  }
  const CutView view = marks.touching ? closeView(scene, marks.focus, kMain) : apartView(scene);
  Drawing drawing{kWidth, kHeight, {}, {}};
  addTitle(drawing,
           shortName(scene.b.name) + (marks.touching ? " (B) pressed into " : " (B) apart from ") +
               shortName(scene.a.name) + " (A)",
           subtitle(scene, marks));
  addCloseView(drawing, scene, marks, view);
  addScaleBar(drawing, view.frame, view.scale);
  addFrame(drawing, view.frame);
  drawing.add(GroupBegin{"figures", {}});
  addFigures(drawing, scene, marks);
  drawing.add(GroupEnd{});
  if (marks.touching) {
    addWholeView(drawing, scene, view, kWhole);
    addPatchFace(drawing, scene, marks, view, kFace);
  }
  addKey(drawing, scene.byPaper());
  return drawing;
}

}  // namespace cloudcontact::program
