// Samples of a cloud against a shape's own formula.
#include "sample_search.h"

namespace cloudcontact::search {

namespace {

// Cosine: normals that differ by more over a sample meet at an edge, 26 deg.
constexpr float kOneFace = 0.9f;

// One level's search.
class ShapeSearch {
 public:
  ShapeSearch(const Direction& dir, const AnalyticShape& shape, const Pose& toShape,
              Candidates& candidates, HitColumns& hits)
      : dir_(dir), shape_(shape), toShape_(toShape), candidates_(candidates), hits_(hits) {}

  void run() {
    candidates_.next.clear();
    if (candidates_.all) {
      const SampleBricks& bricks = dir_.samples.bricks;
      for (std::size_t i = 0; i < bricks.runs.size(); ++i) {
        const V3 center(bricks.x[i], bricks.y[i], bricks.z[i]);
        const float reach = (bricks.radius[i] + 0.5f) * dir_.voxel + dir_.misses.margin;
        if (at(center).depth >= -reach) lookInto(bricks.runs[i]);
      }
    } else {
      for (const SampleRun& run : candidates_.now) lookInto(run);
    }
    std::swap(candidates_.now, candidates_.next);
    candidates_.all = false;
  }

 private:
  ShapePoint at(const V3& grid) const {
    return shapeAt(shape_, toShape_.toWorld(dir_.body.cloud().voxelSize() * grid.cast<double>()));
  }

  // Whether the shape has an edge over a wide sample; looked for where few samples touch.
  bool edgeWithin(const SurfaceSample& s, float depth, const V3& normal) const {
    const float half = kHalfDiagonal * s.width;
    if (dir_.level > 0 || s.width <= kWide || std::abs(depth) > half * dir_.voxel) return false;
    float t1[3], t2[3];
    ccTangents(s.normal, t1, t2);
    const Eigen::Map<const V3> u(t1), v(t2);
    for (const V3& aside : {V3(half * u), V3(-half * u), V3(half * v), V3(-half * v)})
      if (told(s, aside).second.dot(normal) < kOneFace) return true;
    return false;
  }

  std::pair<float, V3> told(const SurfaceSample& s, const V3& aside) const {
    const ShapePoint p = at(Eigen::Map<const V3>(s.position) + aside);
    return {static_cast<float>(p.depth), p.normal.cast<float>()};
  }

  void lookInto(const SampleRun& run) {
    const SampleLevel& level = dir_.samples.levels[dir_.level];
    const float slack = kSlack[dir_.level] + dir_.misses.margin / dir_.voxel;
    for (std::uint32_t k = run.first; k < run.first + run.count; ++k) {
      const SurfaceSample s = level.samples[k];
      const V3 own(s.normal[0], s.normal[1], s.normal[2]);
      const ShapePoint p = at(Eigen::Map<const V3>(s.position));
      const float depth = static_cast<float>(p.depth);
      const V3 normal = p.normal.cast<float>();
      if (edgeWithin(s, depth, normal))
        addParts(
            dir_, s, [&](const V3& aside) { return told(s, aside); }, hits_);
      else if (depth > reachOf(dir_, s.width))
        addHit(dir_, s, depth, normal, false, hits_);
      if (dir_.level > 0 && ccNearBeside(depth / dir_.voxel, slack, kSlope[dir_.level],
                                         turned(dir_.turnToOther, own).dot(normal)))
        handOn(dir_, k, last_, candidates_);
    }
  }

  const Direction& dir_;
  const AnalyticShape& shape_;
  const Pose& toShape_;
  Candidates& candidates_;
  HitColumns& hits_;
  std::uint32_t last_ = kNoCell;
};

}  // namespace

void searchShape(const Direction& dir, const AnalyticShape& shape, const Pose& toShape,
                 Candidates& candidates, HitColumns& hits) {
  ShapeSearch(dir, shape, toShape, candidates, hits).run();
}

}  // namespace cloudcontact::search
