// The two targets of a search: a field, whose records a sample finds in one 8-byte fetch, and a
// shape's formula. A target has
//   void nearBricks(float aside, std::vector<std::uint32_t>& near): numbers of the sample bricks
//     that may touch from where they are, or from up to `aside` [own voxels] away;
//   int measure(bool finer, Lanes& lanes): depth, normal and `facing` of all lanes, with `a` a
//     record of a plane, or none and the reason in `b`; on a coarse level with `finer` also
//     `beside`; returns
//     how many lanes have an edge of the target within them, and lists these in lanes.several;
//   void measurePoints(Lanes& lanes): the same without edges, always with `beside`;
//   void measureParts(Lanes& parts, const SampleColumns& samples): the same for parts of samples,
//     whose x, y, z, a and b come from Candidates::places;
//   const FieldData* field(): null for a shape;
//   float deepAt(const SurfaceSample& s): the depth [m] of a sample below the band.
#pragma once

#include <cloudcontact/law/solid.h>

#include <algorithm>
#include <limits>

#include "contact/field_lanes.h"
#include "contact/pair_frame.h"
#include "contact/sheet_side.h"
#include "kernels/contact/shape_depth.h"
#include "law/triangle_surface.h"

namespace cloudcontact::search {

struct FieldTarget {
  const Direction& dir;
  const FieldData& other;
  float voxel;  // of the other body [m]

  const FieldData* field() const { return &other; }

  void nearBricks(float aside, std::vector<std::uint32_t>& near) const {
    search::nearBricks(dir, other, aside, near);
  }

  void measurePoints(Lanes& lanes) const {
    findRecords(dir, other, lanes);
    search::measure(dir, other, voxel, dir.level > 0, lanes);
  }

  int measure(bool finer, Lanes& lanes) const {
    findRecords(dir, other, lanes);
    search::measure(dir, other, voxel, finer && dir.level > 0, lanes);
    findFacing(dir, lanes);
    if (dir.level == kLevels - 1) return 0;
    return edgesWithin(dir, other, voxel, lanes);
  }

  void measureParts(Lanes& parts, const SampleColumns&) const {
    choosePlanesOfParts(other, voxel, parts);
  }

  float deepAt(const SurfaceSample& s) const {
    const V3 x = applied(dir.toOther, V3(s.position[0], s.position[1], s.position[2]));
    const CcPlace place = ccPlaceOf(other.records().bricks(), x.data());
    const int bricks = other.brickDistance()[static_cast<std::size_t>(place.brick)];
    return ccDepthBelow(bricks, voxel);
  }
};

constexpr double kSurelyAway = 1 - 1e-9;  // of a distance, for rounding
// [voxels] What is farther in front of a sheet touches it from no side.
constexpr double kInFront = 4;
// Cosine of 84 deg: the sides of what stands on a sheet do not face it.
constexpr double kFacesSheet = 0.1;
constexpr double kLooksAtSheet = 0.7;  // cosine of 45 deg

inline const TriangleSurface* surfaceOf(const Solid& shape) {
  const auto* const solid = std::get_if<SurfaceSolid>(&shape);
  return solid ? solid->surface.get() : nullptr;
}

// Places beyond a face of triangles' bounds: no triangle is between two of them, so that all are
// outside if one is.
class BeyondBounds {
 public:
  explicit BeyondBounds(const TriangleSurface* surface) {  // null: of nothing is known
    std::fill_n(ends_, 6, std::numeric_limits<double>::infinity());
    if (!surface) return;
    for (int axis = 0; axis < 3; ++axis) {
      ends_[axis] = surface->bounds().max()[axis];
      ends_[3 + axis] = -surface->bounds().min()[axis];
    }
  }
  // A place that is outside.
  void add(const Vec3& x) {
    for (int face = 0; face < 6; ++face) outside_[face] |= beyond(x, face) > 0;
  }
  // Whether a place is surely outside, and farther than `away` from all triangles.
  bool isOutside(const Vec3& x, double away) const {
    bool is = false;
    for (int face = 0; face < 6; ++face) is |= outside_[face] & (beyond(x, face) > away);
    return is;
  }

 private:
  double beyond(const Vec3& x, int face) const {
    return (face < 3 ? x[face] : -x[face - 3]) - ends_[face];
  }
  double ends_[6];  // of the bounds: above, then below
  bool outside_[6] = {};
};

struct ShapeTarget {
  const Direction& dir;
  const Solid& shape;
  const Pose& toShape;  // from the samples' grid, meters
  const SampleColumns& samples;
  const TriangleSurface* surface = surfaceOf(shape);  // null: none
  // Of a place in the grid [voxels].
  const Eigen::Matrix3d turn =
      dir.body.cloud().voxelSize() * toShape.orientation.toRotationMatrix();
  const std::optional<CcShape> plain = plainShape(shape, toShape, dir.body.cloud().voxelSize());
  const CcVoxel record = ccShapeRecord(std::holds_alternative<HalfSpace>(shape));

  const FieldData* field() const { return nullptr; }

  Vec3 inShape(const V3& grid) const { return turn * grid.cast<double>() + toShape.position; }
  // At a place of sample k.
  std::pair<float, V3> lookUp(const V3& grid, const SampleColumns& of, std::uint32_t k) const {
    if (plain) {
      const CcDepth d = ccShapeDepth(&*plain, grid.data());
      return {d.depth, V3(d.normal[0], d.normal[1], d.normal[2])};
    }
    const SolidPoint p = surface ? onSurface(grid, of, k) : solidAt(shape, inShape(grid));
    return {static_cast<float>(p.depth), p.normal.cast<float>()};
  }

  // Near a border the parts of the cloud may be on different sides of a sheet.
  SolidPoint onSurface(const V3& grid, const SampleColumns& of, std::uint32_t k) const {
    const TriangleSurface::Point p = surface->at(inShape(grid));
    const double height = -p.depth / dir.body.cloud().voxelSize();
    if (!surface->hasBorders() || p.border || height > kInFront) return p;
    const SurfaceSample s = of[k];
    const V3 outward(s.normal[0], s.normal[1], s.normal[2]);
    const int side = sideOfSheet(dir.body.cloud(), grid, outward,
                                 toShape.orientation.conjugate() * p.normal, height);
    SolidPoint turned = p;
    if (side < 0) turned = {-p.depth, -p.normal};
    if (turned.depth > 0 && isPastBorder(turned, grid, outward))
      return {-turned.depth, -turned.normal};
    return turned;
  }

  // Whether a sample behind a sheet is pushed by the sheet's border instead (border_hits.h): where
  // the sheet ends a voxel inside the sample; where the way out past the border is shorter than
  // through the sheet, unless they meet face to face and the border is too deep to push; and on the
  // cloud's sides, which do not face the sheet, if the border is in the cloud.
  bool isPastBorder(const SolidPoint& behind, const V3& grid, const V3& outward) const {
    if (surface->at(inShape(grid - outward)).border) return true;
    const Vec3 foot = inShape(grid) + behind.depth * behind.normal;
    const Vec3 border = surface->borderNearest(foot);
    if (!border.allFinite()) return false;
    const Vec3 place = toShape.toLocal(border) / dir.body.cloud().voxelSize();
    const double facing = -(toShape.orientation * outward.cast<double>()).dot(behind.normal);
    if ((border - foot).norm() < behind.depth) return facing < kLooksAtSheet || !isDeep(place);
    return facing < kFacesSheet && isMatter(dir.body.cloud(), place);
  }

  // Whether a place [voxels] is deeper in the cloud than its field knows.
  bool isDeep(const Vec3& place) const {
    const Eigen::Vector3i v = place.array().floor().cast<int>();
    return isMatter(dir.body.cloud(), place) &&
           ccPlaneCount(dir.body.records().at(v.x(), v.y(), v.z())) == 0;
  }

  static void set(Lanes& lanes, int i, const std::pair<float, V3>& there) {
    lanes.depth[i] = there.first;
    lanes.nx[i] = there.second.x();
    lanes.ny[i] = there.second.y();
    lanes.nz[i] = there.second.z();
  }

  void nearBricks(float aside, std::vector<std::uint32_t>& near) const {
    near.clear();
    const SampleBricks& bricks = dir.samples.bricks;
    // What is as far from the last place asked as that is from the shape, and more, is not near.
    const bool distance = surface ? !surface->hasBorders() : isDistance(shape);
    BeyondBounds beyond(distance ? surface : nullptr);
    Vec3 last = Vec3::Zero();
    double away = 0;  // of the last place from the shape [m]
    for (std::size_t i = 0; i < bricks.runs.size(); ++i) {
      const float reach = (bricks.radius[i] + aside + 0.5f) * dir.voxel;
      const V3 middle(bricks.x[i], bricks.y[i], bricks.z[i]);
      const Vec3 x = inShape(middle);
      const double left = kSurelyAway * away - reach;
      if (distance && left > 0 && (x - last).squaredNorm() < left * left) continue;
      if (beyond.isOutside(x, reach)) continue;
      if (surface) {
        const double more = surface->beyond(x, reach);
        if (more == 0) {
          near.push_back(static_cast<std::uint32_t>(i));
          continue;
        }
        last = x;
        away = more + reach;
        beyond.add(x);
        continue;
      }
      const double depth =
          plain ? ccPointInShape(&*plain, middle.data()).depth : solidAt(shape, x).depth;
      last = x;
      away = -depth;
      if (depth < 0) beyond.add(x);
      if (depth >= -reach) near.push_back(static_cast<std::uint32_t>(i));
    }
  }

  void measurePoints(Lanes& lanes) const { measure(true, lanes); }

  int measure(bool finer, Lanes& lanes) const {
    const int divided = measureDepths(lanes);
    pad(lanes.sample, lanes.count);
    if (finer && dir.level > 0) findBeside(dir, lanes);
    findFacing(dir, lanes);
    return divided;
  }

  int measureDepths(Lanes& lanes) const {
    std::fill_n(lanes.a, lanes.count, record.a);
    std::fill_n(lanes.b, lanes.count, record.b);
    if (plain && plain->solid.kind == CC_HALF_SPACE) {
      measureHalfSpace(lanes);
      return 0;
    }
    if (surface && !surface->hasBorders())
      measureTriangles(lanes);
    else
      for (int i = 0; i < lanes.count; ++i) {
        const std::uint32_t k = lanes.sample[i];
        set(lanes, i, lookUp({samples.x[k], samples.y[k], samples.z[k]}, samples, k));
      }
    if (dir.level > 0 || (surface && !surface->hasJumps())) return 0;
    int divided = 0;
    for (int i = 0; i < lanes.count; ++i) {
      lanes.several[divided] = i;
      divided += edgeWithin(lanes, i);
    }
    return divided;
  }

  // Three loops, so that a processor can overlap the look-ups.
  void measureTriangles(Lanes& lanes) const {
    Vec3 places[kLanes];
    TriangleSurface::Point found[kLanes];
    for (int i = 0; i < lanes.count; ++i) {
      const std::uint32_t k = lanes.sample[i];
      places[i] = inShape({samples.x[k], samples.y[k], samples.z[k]});
    }
    for (int i = 0; i < lanes.count; ++i) found[i] = surface->at(places[i]);
    for (int i = 0; i < lanes.count; ++i)
      set(lanes, i, {static_cast<float>(found[i].depth), found[i].normal.cast<float>()});
  }

  void measureHalfSpace(Lanes& lanes) const {
    for (int i = 0; i < lanes.count; ++i) {
      const std::uint32_t k = lanes.sample[i];
      const float x[3] = {samples.x[k], samples.y[k], samples.z[k]};
      const CcDepth d = ccHalfSpaceDepth(&*plain, x);
      lanes.depth[i] = d.depth;
      lanes.nx[i] = d.normal[0];
      lanes.ny[i] = d.normal[1];
      lanes.nz[i] = d.normal[2];
    }
  }

  // Whether the shape has an edge within a wide sample of the finest level.
  bool edgeWithin(const Lanes& lanes, int i) const {
    const std::uint32_t k = lanes.sample[i];
    const SurfaceSample s = samples[k];
    const float half = ccHalfOverEdge(s.width, lanes.depth[i], dir.voxel);
    if (!(half > 0)) return false;
    const float normal[3] = {lanes.nx[i], lanes.ny[i], lanes.nz[i]};
    float t1[3], t2[3];
    ccTangents(s.normal, t1, t2);
    for (int side = 0; side < 4; ++side) {
      V3 at;
      ccBesideSample(s.position, half, side, t1, t2, at.data());
      const V3 beside = lookUp(at, samples, k).second;
      if (ccDot(beside.data(), normal) < CC_ONE_FACE) return true;
    }
    return false;
  }

  void measureParts(Lanes& parts, const SampleColumns& of) const {
    for (int i = 0; i < parts.count; ++i) {
      const std::uint32_t k = parts.sample[i];
      set(parts, i, lookUp({of.x[k], of.y[k], of.z[k]}, of, k));
    }
  }

  float deepAt(const SurfaceSample&) const { return 0; }  // a formula has no band
};

}  // namespace cloudcontact::search
