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
              Candidates& candidates, std::vector<Hit>& hits)
      : dir_(dir), shape_(shape), toShape_(toShape), candidates_(candidates), hits_(hits) {}

  void run() {
    candidates_.next.clear();
    if (candidates_.all) {
      for (const SampleBrick& brick : dir_.samples.bricks) {
        const V3 center(brick.center[0], brick.center[1], brick.center[2]);
        if (at(center).depth < -(brick.radius + 0.5f) * dir_.voxel - dir_.misses.margin) continue;
        for (std::uint32_t i = brick.first; i < brick.first + brick.count; ++i) lookInto(i);
      }
    } else {
      eachCandidate(dir_, candidates_, [this](std::uint32_t cell) { lookInto(cell); });
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

  void lookInto(std::uint32_t cell) {
    const SampleLevel& level = dir_.samples.levels[dir_.level];
    const SampleCell& c = level.cells[cell];
    for (std::uint32_t k = c.first; k < c.first + c.count; ++k) {
      const SurfaceSample& s = level.samples[k];
      const ShapePoint p = at(Eigen::Map<const V3>(s.position));
      const float depth = static_cast<float>(p.depth);
      const V3 normal = p.normal.cast<float>();
      if (edgeWithin(s, depth, normal))
        addParts(
            dir_, s, [&](const V3& aside) { return told(s, aside); }, hits_);
      else if (depth > reachOf(dir_, s))
        addHit(dir_, s, depth, normal, false, hits_);
      if (mayTouchBeside(dir_, s, depth / dir_.voxel, normal))
        handOn(dir_, cell, last_, candidates_);
    }
  }

  const Direction& dir_;
  const AnalyticShape& shape_;
  const Pose& toShape_;
  Candidates& candidates_;
  std::vector<Hit>& hits_;
  std::uint32_t last_ = kNoCell;
};

}  // namespace

void searchShape(const Direction& dir, const AnalyticShape& shape, const Pose& toShape,
                 Candidates& candidates, std::vector<Hit>& hits) {
  ShapeSearch(dir, shape, toShape, candidates, hits).run();
}

}  // namespace cloudcontact::search
