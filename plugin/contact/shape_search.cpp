// Samples of a cloud against a shape's own formula.
#include "contact/shared_search.h"

namespace cloudcontact::search {

namespace {

// Cosine: normals that differ by more over a sample meet at an edge, 26 deg.
constexpr float kOneFace = 0.9f;

struct ShapeTarget {
  const Direction& dir;
  const Solid& shape;
  const Pose& toShape;  // from the samples' grid, metres
  const SampleColumns& samples;

  SolidPoint at(const V3& grid) const {
    return solidAt(shape, toShape.toWorld(dir.body.cloud().voxelSize() * grid.cast<double>()));
  }
  std::pair<float, V3> told(const V3& grid) const {
    const SolidPoint p = at(grid);
    return {static_cast<float>(p.depth), p.normal.cast<float>()};
  }

  static void set(Lanes& lanes, int i, const std::pair<float, V3>& there) {
    lanes.depth[i] = there.first;
    lanes.nx[i] = there.second.x();
    lanes.ny[i] = there.second.y();
    lanes.nz[i] = there.second.z();
  }

  void nearBricks(std::vector<std::uint32_t>& near) const {
    near.clear();
    const SampleBricks& bricks = dir.samples.bricks;
    for (std::size_t i = 0; i < bricks.runs.size(); ++i) {
      const float reach = (bricks.radius[i] + 0.5f) * dir.voxel + dir.misses.margin;
      if (at({bricks.x[i], bricks.y[i], bricks.z[i]}).depth >= -reach)
        near.push_back(static_cast<std::uint32_t>(i));
    }
  }

  int measure(Lanes& lanes) const {
    const CcVoxel onePlane = ccPackPlanes(0, 1, 0);
    std::fill_n(lanes.a, lanes.count, onePlane.a);
    std::fill_n(lanes.b, lanes.count, onePlane.b);
    if (const HalfSpace* const plane = std::get_if<HalfSpace>(&shape)) {
      measurePlane(*plane, lanes);
      return 0;
    }
    int divided = 0;
    for (int i = 0; i < lanes.count; ++i) {
      const std::uint32_t k = lanes.sample[i];
      const std::pair<float, V3> there = told({samples.x[k], samples.y[k], samples.z[k]});
      set(lanes, i, there);
      lanes.several[divided] = i;
      divided += edgeWithin(k, there.first, there.second);
    }
    return divided;
  }

  // Depth falls by the same along each of the grid's axes everywhere.
  void measurePlane(const HalfSpace& plane, Lanes& lanes) const {
    const V3 n = plane.normal.cast<float>();
    const V3 slope =
        (dir.body.cloud().voxelSize() * (toShape.orientation.conjugate() * plane.normal))
            .cast<float>();
    const float offset = static_cast<float>(plane.offset - plane.normal.dot(toShape.position));
    for (int i = 0; i < lanes.count; ++i) {
      const std::uint32_t k = lanes.sample[i];
      lanes.depth[i] =
          offset - (slope.x() * samples.x[k] + slope.y() * samples.y[k] + slope.z() * samples.z[k]);
      lanes.nx[i] = n.x();
      lanes.ny[i] = n.y();
      lanes.nz[i] = n.z();
    }
  }

  // Whether the shape has an edge over a wide sample; looked for where few samples touch.
  bool edgeWithin(std::uint32_t k, float depth, const V3& normal) const {
    if (dir.level > 0) return false;
    const SurfaceSample s = samples[k];
    const float half = CC_HALF_DIAGONAL * s.width;
    if (s.width <= CC_WIDE || std::abs(depth) > half * dir.voxel) return false;
    float t1[3], t2[3];
    ccTangents(s.normal, t1, t2);
    const Eigen::Map<const V3> u(t1), v(t2), middle(s.position);
    for (const V3& aside : {V3(half * u), V3(-half * u), V3(half * v), V3(-half * v)})
      if (told(middle + aside).second.dot(normal) < kOneFace) return true;
    return false;
  }

  void measureParts(Lanes& parts, const SampleColumns& of) const {
    for (int i = 0; i < parts.count; ++i) {
      const std::uint32_t k = parts.sample[i];
      set(parts, i, told({of.x[k], of.y[k], of.z[k]}));
    }
  }

  float deepAt(const SurfaceSample&) const { return 0; }  // a shape knows its depth everywhere
};

}  // namespace

void searchShape(const Direction& dir, const Solid& shape, const Pose& toShape,
                 Candidates& candidates, HitColumns& hits, HitSearch::Shares& shares) {
  ShapeTarget target{dir, shape, toShape, dir.samples.levels[dir.level].samples};
  searchShared(dir, target, candidates, hits, shares);
}

}  // namespace cloudcontact::search
