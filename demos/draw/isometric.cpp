// Seen along (1, 1, 1) the faces of voxels fall on a lattice of triangles, two for each face. A
// table holds the nearest face of each triangle, which removes hidden faces exactly.
#include "draw/isometric.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <tuple>
#include <vector>

#include "draw/picture_elements.h"

namespace cloudcontact::program {

namespace {

constexpr int kMostBlocks = 72;       // along the longest axis
constexpr double kMaterial = 0.35;    // least mean coverage of a visible block
constexpr double kTilt = 0.81649658;  // projected length of an axis, sqrt(2/3)
constexpr double kSeam = 0.5;         // width of an outline that hides a seam [px]
constexpr double kLeastOutlined = 4;  // length of an edge from which faces are outlined [px]
constexpr int kColorSteps = 6;        // along each of red, green and blue
// Brightness of the faces across x, y and z, with light from above.
constexpr std::array<double, 3> kBrightness = {0.9, 0.8, 1.0};

struct Blocks {
  int step = 1;                                   // voxels along a block's edge
  Eigen::Vector3i low = Eigen::Vector3i::Zero();  // the first block's first voxel
  Eigen::Vector3i size = Eigen::Vector3i::Zero();
  std::vector<bool> full;

  bool at(const Eigen::Vector3i& b) const {
    if ((b.array() < 0).any() || (b.array() >= size.array()).any()) return false;
    return full[static_cast<std::size_t>(b.x() + size.x() * (b.y() + size.y() * b.z()))];
  }
};

double meanCoverage(const Cloud& cloud, const Eigen::Vector3i& low, int step) {
  double sum = 0;
  for (int z = 0; z < step; ++z)
    for (int y = 0; y < step; ++y)
      for (int x = 0; x < step; ++x) sum += cloud.coverage(low.x() + x, low.y() + y, low.z() + z);
  return sum / (255.0 * step * step * step);
}

// Blocks over `size` voxels from `low`.
Blocks blocksOf(const Cloud& cloud, const Eigen::Vector3i& low, const Eigen::Vector3i& size) {
  Blocks blocks;
  blocks.low = low;
  blocks.step = (size.maxCoeff() + kMostBlocks - 1) / kMostBlocks;
  blocks.size = (size.array() + blocks.step - 1) / blocks.step;
  for (int z = 0; z < blocks.size.z(); ++z)
    for (int y = 0; y < blocks.size.y(); ++y)
      for (int x = 0; x < blocks.size.x(); ++x)
        blocks.full.push_back(meanCoverage(cloud, low + blocks.step * Eigen::Vector3i(x, y, z),
                                           blocks.step) >= kMaterial);
  return blocks;
}

// A face by its block and its axis.
struct Face {
  Eigen::Vector3i block;
  int axis;
};

// A lattice triangle: its unit square in (x - z, y - z) and its half.
using Triangle = std::tuple<int, int, bool>;  // true: the half beyond the diagonal, toward y

std::array<Triangle, 2> trianglesOf(const Face& face) {
  const int u = face.block.x() - face.block.z(), w = face.block.y() - face.block.z();
  if (face.axis == 0) return {Triangle{u, w - 1, true}, Triangle{u, w, false}};
  if (face.axis == 1) return {Triangle{u - 1, w, false}, Triangle{u, w, true}};
  return {Triangle{u - 1, w - 1, false}, Triangle{u - 1, w - 1, true}};
}

using Ring = std::vector<std::array<int, 2>>;  // lattice points

Ring cornersOf(const Triangle& triangle) {
  const auto [u, w, beyond] = triangle;
  if (beyond) return {{u, w}, {u + 1, w + 1}, {u, w + 1}};
  return {{u, w}, {u + 1, w}, {u + 1, w + 1}};
}

Ring cornersOf(const Face& face) {
  const int u = face.block.x() - face.block.z(), w = face.block.y() - face.block.z();
  if (face.axis == 0) return {{u, w - 1}, {u + 1, w}, {u + 1, w + 1}, {u, w}};
  if (face.axis == 1) return {{u - 1, w}, {u, w}, {u + 1, w + 1}, {u, w + 1}};
  return {{u - 1, w - 1}, {u, w - 1}, {u, w}, {u - 1, w}};
}

std::map<Triangle, Face> visible(const Blocks& blocks) {
  std::map<Triangle, Face> nearest;
  for (int z = 0; z < blocks.size.z(); ++z)
    for (int y = 0; y < blocks.size.y(); ++y)
      for (int x = 0; x < blocks.size.x(); ++x) {
        const Eigen::Vector3i block(x, y, z);
        if (!blocks.at(block)) continue;
        for (int axis = 0; axis < 3; ++axis) {
          if (blocks.at(block + Eigen::Vector3i::Unit(axis))) continue;
          for (const Triangle& t : trianglesOf({block, axis})) {
            const auto [place, fresh] = nearest.try_emplace(t, Face{block, axis});
            if (!fresh && place->second.block.sum() < block.sum()) place->second = {block, axis};
          }
        }
      }
  return nearest;
}

// The field's normal at the face or behind it, else that of the face.
Vec3 normalAt(const SurfaceField& field, const Face& face, int step) {
  const Cloud& cloud = field.cloud();
  const double block = step * cloud.voxelSize();
  const Vec3 center = cloud.origin() + block * (face.block.cast<double>() + Vec3::Constant(0.5));
  for (const double outward : {0.5, 0.0})
    if (const auto point = field.at(center + outward * block * Vec3::Unit(face.axis)))
      return point->normal;
  return Vec3::Unit(face.axis);
}

// Rounded to few colors, so that many faces form one element.
Color faceColor(const Vec3& normal, int axis) {
  Color color = normalColor(normal);
  for (std::uint8_t* part : {&color.red, &color.green, &color.blue}) {
    const double step = std::round(*part / 255.0 * kColorSteps) / kColorSteps;
    *part = static_cast<std::uint8_t>(
        std::lround(255 * step * kBrightness[static_cast<std::size_t>(axis)]));
  }
  return color;
}

std::uint32_t keyOf(const Color& c) {
  return static_cast<std::uint32_t>(c.red) << 16 | static_cast<std::uint32_t>(c.green) << 8 |
         c.blue;
}

// Polygons grouped by color, outlined in their own color, which hides seams, or in another.
class ByColor {
 public:
  ByColor(std::optional<Color> outline, double width) : outline_(outline), width_(width) {}
  void add(const Color& color, std::vector<Point> ring) {
    Polygons& polygons = all_[keyOf(color)];
    polygons.paint = {color, outline_.value_or(color), width_};
    polygons.rings.push_back(std::move(ring));
  }
  void addTo(Drawing& drawing) {
    for (auto& [key, polygons] : all_) drawing.add(std::move(polygons));
  }

 private:
  std::optional<Color> outline_;
  double width_;
  std::map<std::uint32_t, Polygons> all_;
};

// Centered, at the largest scale at which the bounds fit the frame.
IsometricView viewOf(const Eigen::AlignedBox3d& bounds, const Rectangle& frame) {
  IsometricView view;
  view.origin = bounds.center();
  Eigen::AlignedBox2d paper;
  for (int k = 0; k < 8; ++k)
    paper.extend(view.toPaper(bounds.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k))));
  view.center = frame.center();
  const Point size = 1.12 * paper.sizes();
  view.scale = std::min(frame.size().x() / size.x(), frame.size().y() / size.y());
  return view;
}

// The material of a face: that of the first voxel with coverage behind its middle.
std::size_t materialAt(const Cloud& cloud, const Blocks& blocks, const Face& face) {
  Eigen::Vector3i voxel = blocks.low + blocks.step * face.block;
  for (int axis = 0; axis < 3; ++axis)
    voxel[axis] += axis == face.axis ? blocks.step - 1 : blocks.step / 2;
  for (int k = 0; k < blocks.step; ++k, --voxel[face.axis])
    if (cloud.coverage(voxel.x(), voxel.y(), voxel.z()) > 100)
      return cloud.material(voxel.x(), voxel.y(), voxel.z());
  ++voxel[face.axis];
  return cloud.material(voxel.x(), voxel.y(), voxel.z());
}

Color shaded(Color color, int axis) {
  for (std::uint8_t* part : {&color.red, &color.green, &color.blue})
    *part =
        static_cast<std::uint8_t>(std::lround(*part * kBrightness[static_cast<std::size_t>(axis)]));
  return color;
}

// Draws the visible faces; returns the scale along the axes [px/m].
double addFaces(Drawing& drawing, const Cloud& cloud, const Blocks& blocks,
                const IsometricView& view, const std::function<Color(const Face&)>& colorOf) {
  const double h = cloud.voxelSize(), block = blocks.step * h;
  const Vec3 origin = cloud.origin() + h * blocks.low.cast<double>();
  using FaceName = std::array<int, 4>;
  std::map<FaceName, std::vector<Triangle>> faces;
  for (const auto& [triangle, face] : visible(blocks))
    faces[{face.block.x(), face.block.y(), face.block.z(), face.axis}].push_back(triangle);
  const bool large = kTilt * block * view.scale >= kLeastOutlined;
  ByColor polygons(large ? std::optional(Color{255, 255, 255, 0.6}) : std::nullopt,
                   large ? 0.8 : kSeam);
  const auto draw = [&](const Ring& ring, const Color& color) {
    std::vector<Point> points;
    for (const auto& [u, w] : ring) points.push_back(view.toPaper(origin + block * Vec3(u, w, 0)));
    polygons.add(color, std::move(points));
  };
  for (const auto& [name, triangles] : faces) {
    const Face face{{name[0], name[1], name[2]}, name[3]};
    const Color color = colorOf(face);
    if (triangles.size() == 2)
      draw(cornersOf(face), color);
    else
      draw(cornersOf(triangles.front()), color);
  }
  polygons.addTo(drawing);
  return kTilt * view.scale;
}

}  // namespace

Point IsometricView::toPaper(const Vec3& place) const {
  const Vec3 p = place - origin;
  const Point flat((p.y() - p.x()) / std::sqrt(2.0), (p.x() + p.y() - 2 * p.z()) / std::sqrt(6.0));
  return center + scale * flat;
}

Color normalColor(const Vec3& normal) {
  const auto part = [](double n) {
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(0.5 + 0.5 * n, 0.0, 1.0)));
  };
  return {part(normal.x()), part(normal.y()), part(normal.z())};
}

double addVoxelsFromOutside(Drawing& drawing, const SurfaceField& field, const Rectangle& frame) {
  const Cloud& cloud = field.cloud();
  const Blocks blocks = blocksOf(cloud, Eigen::Vector3i::Zero(), cloud.size());
  return addFaces(drawing, cloud, blocks, viewOf(field.bounds(), frame), [&](const Face& face) {
    return faceColor(normalAt(field, face, blocks.step), face.axis);
  });
}

double addMaterialsFromOutside(Drawing& drawing, const Cloud& cloud,
                               const Eigen::AlignedBox3d& shown, const std::vector<Color>& colors,
                               const Rectangle& frame) {
  const double h = cloud.voxelSize();
  const auto voxelOf = [&](const Vec3& place) -> Eigen::Vector3i {
    return ((place - cloud.origin()) / h)
        .array()
        .round()
        .max(0)
        .min(cloud.size().cast<double>().array())
        .cast<int>();
  };
  const Eigen::Vector3i low = voxelOf(shown.min()), high = voxelOf(shown.max());
  if ((high.array() <= low.array()).any()) return 1;
  const Blocks blocks = blocksOf(cloud, low, high - low);
  return addFaces(drawing, cloud, blocks, viewOf(shown, frame), [&](const Face& face) {
    const std::size_t material = materialAt(cloud, blocks, face);
    return shaded(colors[std::min(material, colors.size() - 1)], face.axis);
  });
}

void addNormalBall(Drawing& drawing, const Point& center, double radius) {
  IsometricView view;
  view.center = center;
  view.scale = radius;
  const Vec3 right = Vec3(-1, 1, 0).normalized(), up = Vec3(-1, -1, 2).normalized();
  const Vec3 toward = Vec3(1, 1, 1).normalized();
  constexpr int kRings = 8, kSectors = 48;
  const auto onBall = [&](int ring, int sector) {  // rings narrow toward the rim, which is steep
    const double angle = 2 * std::numbers::pi * sector / kSectors;
    const double out = std::sin(std::numbers::pi / 2 * ring / kRings);
    return Point(out * std::cos(angle), out * std::sin(angle));
  };
  ByColor polygons({}, kSeam);
  for (int ring = 0; ring < kRings; ++ring)
    for (int sector = 0; sector < kSectors; ++sector) {
      const std::array<Point, 4> corners = {onBall(ring, sector), onBall(ring + 1, sector),
                                            onBall(ring + 1, sector + 1), onBall(ring, sector + 1)};
      const Point p = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
      const Vec3 normal = p.x() * right - p.y() * up + std::sqrt(1 - p.squaredNorm()) * toward;
      std::vector<Point> points;
      for (const Point& corner : corners) points.push_back(center + radius * corner);
      polygons.add(normalColor(normal), std::move(points));
    }
  polygons.addTo(drawing);
  const char* names[] = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 tip = Vec3::Unit(axis);
    drawing.add(arrow(view.toPaper(1.24 * tip), view.toPaper(1.75 * tip), kInk, 2));
    drawing.add(Text{view.toPaper(2.0 * tip) + Point(0, 5), names[axis], kTextSize, kInk,
                     Align::Middle, true});
  }
}

}  // namespace cloudcontact::program
