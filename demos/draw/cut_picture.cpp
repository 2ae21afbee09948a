// Finds the removed voxels and shows the body around them: a box two and a half times as wide as
// the cut.
#include "draw/cut_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "draw/cloud_slice.h"
#include "draw/isometric.h"
#include "draw/picture_elements.h"
#include "draw/tissue_colors.h"

namespace cloudcontact::program {

namespace {

constexpr double kHeight = 610;
constexpr double kTop = 86, kEnd = 536;
const std::array<Rectangle, 3> kFrames = {
    {{{kMargin, kTop}, {400, kEnd}}, {{412, kTop}, {788, kEnd}}, {{800, kTop}, {1176, kEnd}}}};
constexpr double kRoom = 2.5;      // width of the box, relative to the cut
constexpr double kLeastRoom = 16;  // least half width of the box [voxels]
constexpr double kLeastCell = 2;   // smaller voxels are merged into blocks [px]
constexpr int kShades = 8;
constexpr double kGone = 0.3;  // ink of the removed part

// Bounds and middle of the removed part [m].
struct Cut {
  Eigen::AlignedBox3d bounds;
  Vec3 middle = Vec3::Zero();
};

template <typename What>
void forEachVoxel(const Cloud& cloud, What&& what) {
  const Eigen::Vector3i size = cloud.size();
  for (int z = 0; z < size.z(); ++z)
    for (int y = 0; y < size.y(); ++y)
      for (int x = 0; x < size.x(); ++x) what(x, y, z);
}

Cut cutOf(const Cloud& before, const Cloud& after) {
  Cut cut;
  Eigen::AlignedBox3d body;
  double weight = 0;
  forEachVoxel(before, [&](int x, int y, int z) {
    const int was = before.coverage(x, y, z);
    if (was == 0) return;
    const Vec3 place = before.center(x, y, z);
    body.extend(place);
    const int gone = was - after.coverage(x, y, z);
    if (gone <= 0) return;
    cut.bounds.extend(place);
    cut.middle += gone * place;
    weight += gone;
  });
  if (!(weight > 0)) return {body, body.isEmpty() ? before.origin() : body.center()};
  cut.middle /= weight;
  return cut;
}

// A cube around the cut, within the body's bounds.
Eigen::AlignedBox3d roomAbout(const Cut& cut, const Cloud& cloud) {
  const double h = cloud.voxelSize();
  const double half = std::max(kRoom / 2 * cut.bounds.sizes().maxCoeff(), kLeastRoom * h);
  const Vec3 middle = cut.bounds.center();
  const Eigen::AlignedBox3d body(cloud.origin(),
                                 Vec3(cloud.origin() + h * cloud.size().cast<double>()));
  return Eigen::AlignedBox3d(middle - Vec3::Constant(half), middle + Vec3::Constant(half))
      .intersection(body);
}

// Cells of a slice by appearance: removed or not, material, coverage.
using Look = std::tuple<bool, int, int>;
using Looks = std::map<Look, Polygons>;

struct SliceCell {
  int was = 0, is = 0;  // in 1/255, mean of the cell's voxels
  int material = 0;
};

SliceCell cellAt(const Cloud& before, const Cloud& after, const Slice& slice,
                 const Eigen::Vector3i& low, int step) {
  SliceCell cell;
  Eigen::Vector3i v = low;
  for (int k = 0; k < step * step; ++k) {
    v[slice.right] = low[slice.right] + k % step;
    v[slice.up] = low[slice.up] + k / step;
    const int was = before.coverage(v.x(), v.y(), v.z());
    if (was > 0) cell.material = before.material(v.x(), v.y(), v.z());
    cell.was += was;
    cell.is += after.coverage(v.x(), v.y(), v.z());
  }
  cell.was /= step * step, cell.is /= step * step;
  return cell;
}

int shadeOf(int coverage) {
  return static_cast<int>(std::lround(kShades * coverage / 255.0));
}

void addCell(Looks& looks, const SliceCell& cell, const std::vector<Point>& ring) {
  if (shadeOf(cell.was) > shadeOf(cell.is))
    looks[{true, cell.material, shadeOf(cell.was)}].rings.push_back(ring);
  if (shadeOf(cell.is) > 0) looks[{false, cell.material, shadeOf(cell.is)}].rings.push_back(ring);
}

void addMaterials(Drawing& drawing, const Cloud& before, const Cloud& after, const Slice& slice,
                  const CutView& view, const std::vector<Color>& colors) {
  const double h = before.voxelSize();
  const int step = std::max(1, static_cast<int>(std::ceil(kLeastCell / (h * view.scale))));
  const Vec3 low = (view.toWorld({view.frame.low.x(), view.frame.high.y()}) - before.origin()) / h;
  const Vec3 high = (view.toWorld({view.frame.high.x(), view.frame.low.y()}) - before.origin()) / h;
  const auto first = [&](int axis) {
    return std::max(0, static_cast<int>(std::floor(low[axis]))) / step * step;
  };
  const auto end = [&](int axis) {
    return std::min(before.size()[axis], static_cast<int>(std::ceil(high[axis])));
  };
  Eigen::Vector3i voxel;
  voxel[slice.axis] =
      static_cast<int>(std::floor((view.origin[slice.axis] - before.origin()[slice.axis]) / h));
  Looks looks;
  for (int v = first(slice.up); v < end(slice.up); v += step)
    for (int u = first(slice.right); u < end(slice.right); u += step) {
      voxel[slice.right] = u;
      voxel[slice.up] = v;
      const SliceCell cell = cellAt(before, after, slice, voxel, step);
      if (cell.was == 0) continue;
      const Point at = view.toPaper(before.origin() + h * voxel.cast<double>());
      const Point size = Point(step * h * view.scale, -step * h * view.scale);
      addCell(looks, cell, ringOf({at + Point(0, size.y()), at + Point(size.x(), 0)}));
    }
  for (auto& [look, polygons] : looks) {
    const auto [gone, material, shade] = look;
    Color color = colors[std::min(static_cast<std::size_t>(material), colors.size() - 1)];
    color.alpha = static_cast<double>(shade) / kShades * (gone ? kGone : 1.0);
    if (color.alpha >= 1)
      polygons.paint = {color, color, 0.4};  // an outline in the same color hides the seams
    else
      polygons.paint = {color, std::nullopt, 0};
  }
  // The removed part is drawn first.
  for (const bool gone : {true, false})
    for (auto& [look, polygons] : looks)
      if (std::get<0>(look) == gone) drawing.add(std::move(polygons));
}

void addSliceFrame(Drawing& drawing, const Cloud& before, const Cloud& after, const Cut& cut,
                   const Eigen::AlignedBox3d& shown, const Slice& slice, const Rectangle& frame,
                   const std::vector<Color>& colors) {
  CutView view;
  view.frame = belowCaption(frame);
  view.origin = shown.center();
  view.origin[slice.axis] = cut.middle[slice.axis];
  view.right = Vec3::Unit(slice.right);
  view.up = Vec3::Unit(slice.up);
  const Vec3 size = 1.06 * shown.sizes();
  view.scale =
      std::min(view.frame.size().x() / size[slice.right], view.frame.size().y() / size[slice.up]);
  drawing.add(GroupBegin{std::string("slice-") + "xyz"[slice.axis], view.frame});
  addMaterials(drawing, before, after, slice, view, colors);
  drawing.add(GroupEnd{});
  addCaption(drawing, frame, slice.caption, view.scale);
  addFrame(drawing, frame);
}

void addKey(Drawing& drawing, const std::vector<std::string>& names,
            const std::vector<Color>& colors) {
  const double y = kEnd + 40;
  double x = kMargin;
  drawing.add(GroupBegin{"key", {}});
  for (std::size_t t = 0; t < names.size(); ++t)
    x = addTissueKey(drawing, {x, y}, names[t], colors[t]);
  Color faint = colors[0];
  faint.alpha = kGone;
  addTissueKey(drawing, {x, y}, "cut away", faint);
  drawing.add(GroupEnd{});
}

}  // namespace

Drawing cutPicture(const Cloud& before, const Cloud& after, const CutPictureText& words) {
  if (before.empty() || before.size() != after.size() || before.voxelSize() != after.voxelSize())
    throw std::invalid_argument("cutPicture: both clouds must be of one grid");
  const Cut cut = cutOf(before, after);
  const Eigen::AlignedBox3d shown = roomAbout(cut, before);
  std::vector<std::string> names = words.names.empty() ? before.materials() : words.names;
  if (names.empty()) names = {"material"};
  const std::vector<Color> colors = tissueColors(names);
  Drawing drawing{kWidth, kHeight, {}, {}};
  addTitle(drawing, words.title, words.below);
  Eigen::AlignedBox3d outside = shown;
  if (words.opened) outside.max().y() = cut.middle.y();
  const Rectangle inner = belowCaption(kFrames[0]);
  drawing.add(GroupBegin{"outside", inner});
  const double alongAxes = addMaterialsFromOutside(drawing, after, outside, colors, inner);
  drawing.add(GroupEnd{});
  addCaption(drawing, kFrames[0], words.opened ? "cut open through its middle" : "from outside",
             alongAxes);
  addFrame(drawing, kFrames[0]);
  addSliceFrame(drawing, before, after, cut, shown, kSlices[2], kFrames[1], colors);
  addSliceFrame(drawing, before, after, cut, shown, kSlices[1], kFrames[2], colors);
  addKey(drawing, names, colors);
  return drawing;
}

}  // namespace cloudcontact::program
