// Draws slices: voxels as shaded squares, the field's surface, and surface normals.
#include "draw/cloud_slice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "draw/picture_elements.h"

namespace cloudcontact::program {

namespace {

constexpr int kShades = 8;
constexpr double kLeastOutlined = 5;      // voxels smaller than this get no outline [px]
constexpr double kLeastCell = 2;          // smaller voxels are merged into blocks [px]
constexpr int kLookWidth = 20;            // voxels across the close-up
constexpr double kLookMargin = 1.5;       // around the body in it [voxels]
constexpr int kLookReach = 5;             // half width of a rated square [voxels]
constexpr std::size_t kMostPlaces = 400;  // rated in a slice
constexpr double kVectorLength = 0.85;    // of a normal's arrow [voxels]

// Mean coverage of a square of voxels, whether all are full, and the first one's material.
struct Cell {
  double coverage = 0;
  bool inside = true;
  int material = 0;
};

Cell cellAt(const Cloud& cloud, const Slice& slice, Eigen::Vector3i voxel, int step) {
  Cell cell;
  const Eigen::Vector3i low = voxel;
  cell.material = cloud.material(low.x(), low.y(), low.z());
  for (int v = 0; v < step; ++v)
    for (int u = 0; u < step; ++u) {
      voxel[slice.right] = low[slice.right] + u;
      voxel[slice.up] = low[slice.up] + v;
      const int coverage = cloud.coverage(voxel.x(), voxel.y(), voxel.z());
      cell.coverage += coverage / (255.0 * step * step);
      cell.inside &= coverage == 255;
    }
  return cell;
}

void addSliceVoxels(Drawing& drawing, const Cloud& cloud, const Slice& slice, const CutView& view) {
  const double h = cloud.voxelSize();
  const int step = std::max(1, static_cast<int>(std::ceil(kLeastCell / (h * view.scale))));
  std::map<int, Polygons> shades;  // by coverage; inside voxels at kShades + 1 + material
  Eigen::Vector3i voxel;
  voxel[slice.axis] =
      static_cast<int>(std::floor((view.origin[slice.axis] - cloud.origin()[slice.axis]) / h));
  const Point half = Point::Constant(step * h * view.scale / 2);
  for (int v = 0; v < cloud.size()[slice.up]; v += step)
    for (int u = 0; u < cloud.size()[slice.right]; u += step) {
      voxel[slice.right] = u;
      voxel[slice.up] = v;
      const Cell cell = cellAt(cloud, slice, voxel, step);
      if (cell.coverage <= 0) continue;
      Vec3 middle = voxel.cast<double>();
      middle[slice.right] += 0.5 * step;
      middle[slice.up] += 0.5 * step;
      const Point at = view.toPaper(cloud.origin() + h * middle);
      const auto shade = static_cast<int>(std::lround(kShades * cell.coverage));
      shades[cell.inside ? kShades + 1 + cell.material : shade].rings.push_back(
          ringOf({at - half, at + half}));
    }
  const bool outlined = h * view.scale >= kLeastOutlined;
  for (auto& [k, squares] : shades) {
    Color color = k > kShades ? insideColor(k - kShades - 1) : kInterface;
    if (k <= kShades) color.alpha = inkOf(static_cast<double>(k) / kShades);
    squares.paint = {color, std::nullopt, 0.8};
    if (outlined) squares.paint.stroke = kPaperWhite;
    drawing.add(std::move(squares));
  }
}

// Rates how much surface a square of voxels shows. Surface voxels count by the angle between slice
// and surface, down to -2 where the two are parallel.
double surfaceAround(const SurfaceField& field, const Slice& slice, const Eigen::Vector3i& middle) {
  const Cloud& cloud = field.cloud();
  double sum = 0;
  Eigen::Vector3i voxel = middle;
  for (int v = -kLookReach; v <= kLookReach; ++v)
    for (int u = -kLookReach; u <= kLookReach; ++u) {
      voxel[slice.right] = middle[slice.right] + u;
      voxel[slice.up] = middle[slice.up] + v;
      const int coverage = cloud.coverage(voxel.x(), voxel.y(), voxel.z());
      if (coverage == 0 || coverage == 255) continue;
      if (const auto point = field.at(cloud.center(voxel.x(), voxel.y(), voxel.z())))
        sum += 1 - 3 * std::pow(point->normal[slice.axis], 2);
    }
  return sum;
}

}  // namespace

Color insideColor(int material) {
  static constexpr Color kTints[] = {{214, 219, 227}, {240, 222, 184}, {232, 190, 186},
                                     {196, 222, 196}, {214, 200, 230}, {186, 222, 228}};
  return kTints[material % 6];
}

double inkOf(double coverage) {
  return 0.1 + 0.8 * coverage;
}

// Through the middle of the voxel layer at the center of mass.
CutView sliceView(const SurfaceField& field, const Vec3& center, const Slice& slice,
                  const Rectangle& frame, double scale) {
  CutView view;
  view.origin = field.bounds().center();
  const Cloud& cloud = field.cloud();
  const double h = cloud.voxelSize(), start = cloud.origin()[slice.axis];
  view.origin[slice.axis] = start + (std::floor((center[slice.axis] - start) / h) + 0.5) * h;
  view.right = Vec3::Unit(slice.right);
  view.up = Vec3::Unit(slice.up);
  view.frame = frame;
  view.scale = scale;
  return view;
}

void addSlice(Drawing& drawing, const PictureBody& body, const Slice& slice, const CutView& view) {
  addSliceVoxels(drawing, body.field->cloud(), slice, view);
  const double voxel = body.field->cloud().voxelSize() * view.scale;
  const double spacing = std::clamp(0.4 * voxel, 1.5, 6.0);
  drawing.add(Polygons{surfaceLines(body, view, spacing), {{}, kSurface, 1.1}, false});
}

CloseLook closeLookAt(const SurfaceField& field, const Vec3& center) {
  const Cloud& cloud = field.cloud();
  const Vec3 middle = (center - cloud.origin()) / cloud.voxelSize();
  CloseLook best;
  double most = -std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < kSlices.size(); ++k) {
    const Slice& slice = kSlices[k];
    std::vector<Eigen::Vector3i> places;
    for (std::size_t i = 0; i < field.sampleCount(); ++i) {
      const SurfaceSample s = field.sample(i);
      const Vec3 at(s.position[0], s.position[1], s.position[2]);
      if (std::floor(at[slice.axis]) == std::floor(middle[slice.axis]))
        places.push_back(at.array().floor().cast<int>());
    }
    for (std::size_t i = 0; i < places.size(); i += places.size() / kMostPlaces + 1) {
      const double score = surfaceAround(field, slice, places[i]);
      if (score <= most) continue;
      most = score;
      best = {k, cloud.center(places[i].x(), places[i].y(), places[i].z())};
    }
  }
  return best;
}

CutView closeLookView(const SurfaceField& field, const CloseLook& look, const Rectangle& frame) {
  const double scale = frame.size().x() / (kLookWidth * field.cloud().voxelSize());
  CutView view = sliceView(field, look.place, kSlices[look.slice], frame, scale);
  // Shifted toward the body if most of the frame would be empty.
  const Slice& slice = kSlices[look.slice];
  const Eigen::AlignedBox3d bounds = field.bounds();
  for (const auto& [axis, px] :
       {std::pair(slice.right, frame.size().x()), std::pair(slice.up, frame.size().y())}) {
    const double half = px / (2 * scale) - kLookMargin * field.cloud().voxelSize();
    const double low = bounds.min()[axis] + half, high = bounds.max()[axis] - half;
    view.origin[axis] =
        low < high ? std::clamp(look.place[axis], low, high) : bounds.center()[axis];
  }
  return view;
}

void addSurfaceNormals(Drawing& drawing, const PictureBody& body, const Slice& slice,
                       const CutView& view) {
  const Cloud& cloud = body.field->cloud();
  const double h = cloud.voxelSize();
  const Vec3 low = (view.toWorld({view.frame.low.x(), view.frame.high.y()}) - cloud.origin()) / h;
  const Vec3 high = (view.toWorld({view.frame.high.x(), view.frame.low.y()}) - cloud.origin()) / h;
  Eigen::Vector3i voxel = low.array().floor().cast<int>();
  for (int v = voxel[slice.up]; v <= high[slice.up]; ++v)
    for (int u = static_cast<int>(std::floor(low[slice.right])); u <= high[slice.right]; ++u) {
      voxel[slice.right] = u;
      voxel[slice.up] = v;
      const int coverage = cloud.coverage(voxel.x(), voxel.y(), voxel.z());
      const Vec3 center = cloud.center(voxel.x(), voxel.y(), voxel.z());
      const auto point = body.field->at(center);
      if (coverage == 0 || coverage == 255 || !point) continue;
      const Point along = view.direction(point->normal), start = view.toPaper(center);
      if (along.norm() < 0.4) continue;  // points at the viewer: too short to show
      drawing.add(arrow(start, start + kVectorLength * h * view.scale * along, kSurface, 1.5));
    }
}

void addCenterMark(Drawing& drawing, const Point& at) {
  drawing.add(Circle{at, 5, {std::nullopt, kCenter, 2}});
  drawing.add(Circle{at, 1.5, {kCenter, std::nullopt, 0}});
}

}  // namespace cloudcontact::program
