// Coarser samples for large contacts: a model of no more than a query needs. Of a cell's samples
// that look the same way the one nearest to their centroid stands for all, with their area. It
// keeps its own place, normal and width: a merged sample, wider and flatter than any piece of the
// surface, made the M16 thread three times as deep (0.21 mm for 0.07) and turned its force by 3 %.
#include "field_builder.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace cloudcontact {

namespace {

constexpr float kAlike = 0.95f;  // cosine: 18 deg; across more than that depth is not linear

struct Group {
  Eigen::Vector3f vector = Eigen::Vector3f::Zero();  // sum of area times normal
  Eigen::Vector3f first = Eigen::Vector3f::Zero();   // sum of area times position
  float area = 0;
  std::vector<std::uint32_t> members;

  void add(const SurfaceSample& s, std::uint32_t index) {
    vector += s.area * Eigen::Map<const Eigen::Vector3f>(s.normal);
    first += s.area * Eigen::Map<const Eigen::Vector3f>(s.position);
    area += s.area;
    members.push_back(index);
  }

  SurfaceSample sample(const std::vector<SurfaceSample>& samples) const {
    const Eigen::Vector3f centroid = first / area;
    const auto away = [&](std::uint32_t i) {
      return (Eigen::Map<const Eigen::Vector3f>(samples[i].position) - centroid).squaredNorm();
    };
    SurfaceSample s = samples[*std::min_element(
        members.begin(), members.end(),
        [&](std::uint32_t a, std::uint32_t b) { return away(a) < away(b); })];
    s.area = vector.norm();
    // Within its own plane it moves to the centroid: on a face along the grid all four of a cell
    // are as near, and the first of each would shift a cube's centre of force by 0.37 voxel.
    Eigen::Map<Eigen::Vector3f> place(s.position);
    const Eigen::Map<const Eigen::Vector3f> normal(s.normal);
    const Eigen::Vector3f aside = centroid - place;
    place += aside - normal.dot(aside) * normal;
    return s;
  }
};

}  // namespace

std::vector<SurfaceSample> coarsen(const std::vector<SurfaceSample>& samples, int cell) {
  const auto key = [&](const SurfaceSample& s) {
    const auto at = [&](int axis) { return static_cast<int>(std::floor(s.position[axis])) / cell; };
    return std::tuple(at(2), at(1), at(0));
  };
  std::vector<std::uint32_t> order(samples.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::uint32_t>(i);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return key(samples[a]) < key(samples[b]);
  });
  std::vector<SurfaceSample> coarse;
  std::vector<Group> groups;
  for (std::size_t i = 0; i < order.size();) {
    groups.clear();
    const auto here = key(samples[order[i]]);
    for (; i < order.size() && key(samples[order[i]]) == here; ++i) {
      const SurfaceSample& s = samples[order[i]];
      const Eigen::Map<const Eigen::Vector3f> n(s.normal);
      const auto group = std::find_if(groups.begin(), groups.end(), [&](const Group& m) {
        return m.vector.normalized().dot(n) > kAlike;
      });
      (group == groups.end() ? groups.emplace_back() : *group).add(s, order[i]);
    }
    for (const Group& g : groups) coarse.push_back(g.sample(samples));
  }
  return coarse;
}

}  // namespace cloudcontact
