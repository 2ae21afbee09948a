// Cuts voxels and surfaces by a plane.
#include "draw/cut_view.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cloudcontact::program {

namespace {

constexpr double kLeastUp = 0.3;  // length of z in the plane, below which it no longer points up

// Corners of the section of the plane n.x = offset with the unit cube around the origin, unordered.
std::vector<Vec3> cubeCut(const Vec3& n, double offset) {
  std::vector<Vec3> corners;
  for (int axis = 0; axis < 3; ++axis)
    for (int k = 0; k < 4; ++k) {
      Vec3 low;
      low[axis] = -0.5;
      low[(axis + 1) % 3] = (k & 1) ? 0.5 : -0.5;
      low[(axis + 2) % 3] = (k & 2) ? 0.5 : -0.5;
      const double start = n.dot(low) - offset, end = start + n[axis];
      if ((start < 0) == (end < 0)) continue;
      low[axis] += start / (start - end);
      corners.push_back(low);
    }
  return corners;
}

void sortAround(std::vector<Point>& points) {
  Point middle = Point::Zero();
  for (const Point& p : points) middle += p / static_cast<double>(points.size());
  std::sort(points.begin(), points.end(), [&](const Point& a, const Point& b) {
    return std::atan2(a.y() - middle.y(), a.x() - middle.x()) <
           std::atan2(b.y() - middle.y(), b.x() - middle.x());
  });
}

struct VoxelRange {
  Eigen::Vector3i low, high;
};

// A range of voxels that contains all in the frame.
VoxelRange voxelsIn(const Cloud& cloud, const Pose& pose, const CutView& view) {
  Eigen::AlignedBox3d box;
  for (const Point& corner : ringOf(view.frame))
    box.extend(Vec3((pose.toLocal(view.toWorld(corner)) - cloud.origin()) / cloud.voxelSize()));
  const Vec3 top = cloud.size().cast<double>() - Vec3::Ones();
  const Vec3 low = (box.min().array() - 2).floor().max(0);
  const Vec3 high = (box.max().array() + 2).ceil().min(top.array());
  return {low.cast<int>(), high.cast<int>()};
}

// Adds the zero level in a cell with values at its four corners, counter-clockwise.
void addLevel(const std::array<Point, 4>& corners, const std::array<double, 4>& values,
              std::vector<std::vector<Point>>& lines) {
  std::vector<Point> crossings;
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t next = (k + 1) % 4;
    if ((values[k] < 0) == (values[next] < 0)) continue;
    const double share = values[k] / (values[k] - values[next]);
    crossings.push_back(corners[k] + share * (corners[next] - corners[k]));
  }
  for (std::size_t k = 0; k + 1 < crossings.size(); k += 2)
    lines.push_back({crossings[k], crossings[k + 1]});
}

}  // namespace

CutView viewAcross(const Vec3& origin, const Vec3& across, const Rectangle& frame, double scale) {
  CutView view;
  view.origin = origin;
  view.frame = frame;
  view.scale = scale;
  const auto inPlane = [&](const Vec3& v) -> Vec3 { return v - across.dot(v) * across; };
  const Vec3 z = inPlane(Vec3::UnitZ());
  view.up = (z.norm() > kLeastUp ? z : inPlane(Vec3::UnitY())).normalized();
  view.right = view.up.cross(across);
  // Seen from the other side, so that x runs to the right.
  if (view.right.x() + view.right.y() < 0) view.right = -view.right;
  return view;
}

std::vector<CutVoxel> cutVoxels(const Cloud& cloud, const Pose& pose, const CutView& view) {
  const VoxelRange range = voxelsIn(cloud, pose, view);
  const double h = cloud.voxelSize();
  const Vec3 n = pose.orientation.conjugate() * view.across();
  const double reach = n.cwiseAbs().sum() / 2;
  std::vector<CutVoxel> found;
  for (int z = range.low.z(); z <= range.high.z(); ++z)
    for (int y = range.low.y(); y <= range.high.y(); ++y)
      for (int x = range.low.x(); x <= range.high.x(); ++x) {
        const std::uint8_t coverage = cloud.coverage(x, y, z);
        if (coverage == 0) continue;
        CutVoxel cut{{x, y, z}, coverage, pose.toWorld(cloud.center(x, y, z)), {}};
        const double offset = -view.distance(cut.center) / h;
        if (std::abs(offset) >= reach) continue;
        for (const Vec3& corner : cubeCut(n, offset))
          cut.outline.push_back(view.toPaper(cut.center + pose.orientation * Vec3(h * corner)));
        if (cut.outline.size() < 3) continue;
        if (std::none_of(cut.outline.begin(), cut.outline.end(),
                         [&](const Point& p) { return view.frame.contains(p); }))
          continue;
        sortAround(cut.outline);
        found.push_back(std::move(cut));
      }
  return found;
}

std::vector<std::vector<Point>> surfaceLines(const PictureBody& body, const CutView& view,
                                             double spacing) {
  const Point size = view.frame.size();
  const int columns = static_cast<int>(std::ceil(size.x() / spacing)) + 1;
  const int rows = static_cast<int>(std::ceil(size.y() / spacing)) + 1;
  const auto place = [&](int x, int y) -> Point { return view.frame.low + spacing * Point(x, y); };
  std::vector<std::optional<double>> depth;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const std::optional<FieldPoint> point = body.at(view.toWorld(place(x, y)));
      depth.push_back(point ? std::optional(point->depth) : std::nullopt);
    }
  const auto at = [&](int x, int y) { return depth[static_cast<std::size_t>(y * columns + x)]; };
  std::vector<std::vector<Point>> lines;
  for (int y = 0; y + 1 < rows; ++y)
    for (int x = 0; x + 1 < columns; ++x) {
      const auto a = at(x, y), b = at(x + 1, y), c = at(x + 1, y + 1), d = at(x, y + 1);
      if (!a || !b || !c || !d) continue;  // far from the surface
      addLevel({place(x, y), place(x + 1, y), place(x + 1, y + 1), place(x, y + 1)},
               {*a, *b, *c, *d}, lines);
    }
  return lines;
}

std::vector<std::vector<Point>> materialStripes(const PictureBody& body, const CutView& view,
                                                double stripe, int material) {
  std::vector<std::vector<Point>> stripes;
  const auto isIn = [&](const Vec3& world) {
    return body.coverageAt(world) >= 0.5 && body.materialAt(world) == material;
  };
  for (double y = view.frame.low.y(); y < view.frame.high.y(); y += stripe) {
    double start = -1;
    for (double x = view.frame.low.x(); x <= view.frame.high.x() + stripe; x += stripe) {
      const bool inside =
          x < view.frame.high.x() && isIn(view.toWorld({x + stripe / 2, y + stripe / 2}));
      if (inside && start < 0) start = x;
      if (inside || start < 0) continue;
      stripes.push_back(ringOf({{start, y}, {x, y + stripe}}));
      start = -1;
    }
  }
  return stripes;
}

}  // namespace cloudcontact::program
