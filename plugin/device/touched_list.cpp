// Packs collision voxels, and sums them on the CPU.
#include "device/touched_list.h"

#include <oneapi/tbb/parallel_for.h>

#include <cloudcontact/contact/paper_body.h>

#include <stdexcept>

namespace cloudcontact {

TouchedList::TouchedList(const BaseVectorBricks& field,
                         Span<const Span<const CollisionVoxel>> areas, bool hardness) {
  const Vec3& gr = field.window.representative;
  terms = {gr.x(), gr.y(), gr.z()};
  const std::vector<double> h = hardnessOf(field.tissues, hardness);
  terms.insert(terms.end(), h.begin(), h.end());
  firsts.reserve(areas.size() + 1);
  for (const Span<const CollisionVoxel> area : areas) {
    firsts.push_back(static_cast<uint>(voxels.size()));
    for (const CollisionVoxel& v : area) {
      if (!field.contains(v.voxel))
        throw std::out_of_range("DeviceWorkpiece::digitalNormals: a voxel lies outside the grid");
      voxels.push_back({static_cast<ushort>(v.voxel.x()), static_cast<ushort>(v.voxel.y()),
                        static_cast<ushort>(v.voxel.z()), 0, v.share, v.ability});
    }
  }
  firsts.push_back(static_cast<uint>(voxels.size()));
}

std::vector<CcNormalSum> TouchedList::sums(const BaseVectorBricks& field) const {
  const CcWorkpiece workpiece = field.workpiece();
  std::vector<CcNormalSum> all(firsts.size() - 1);
  tbb::parallel_for(std::size_t{0}, all.size(), [&](std::size_t area) {
    CcNormalSum sum = ccNoVectors();
    for (uint lane = 0; lane < CC_NORMAL_LANES; ++lane)
      ccAddLane(&sum, ccSumLane(&workpiece, terms.data(), voxels.data(), firsts[area] + lane,
                                firsts[area + 1]));
    all[area] = sum;
  });
  return all;
}

}  // namespace cloudcontact
