// Sums over the eight voxels that a cube of a voxel's edge meets.
#include "contact/particle_matter.h"

#include <algorithm>

#include "kernels/cut/digital_normal.h"

namespace cloudcontact {

namespace {

const Tissue& tissueAt(const TissueTable& tissues, const Cloud& cloud, const VoxelIndex& v) {
  return tissues[tissues.size() > 1 ? cloud.material(v.x(), v.y(), v.z()) : 0];
}

}  // namespace

ParticleTouch touchOf(const TouchedCloud& touched, const Cloud& cloud, const Vec3& local,
                      double depth, const Vec3& normal) {
  ParticleTouch touch;
  if (!touched.tissues) touch.spring = touched.spring;
  if (!touched.tissues && !touched.paper) return touch;
  const double h = cloud.voxelSize();
  const Vec3 at = local - std::max(0.0, 0.5 * h - depth) * normal;
  const Vec3 grid = (at - cloud.origin()) / h - Vec3::Constant(0.5);
  const VoxelIndex low = grid.array().floor().cast<int>();
  const Vec3 upper = grid - low.cast<double>();
  CcTissueSum sum{};
  CcNormalSum vectors = ccNoVectors();
  for (int bits = 0; bits < 8; ++bits) {
    const VoxelIndex v = low + VoxelIndex(bits & 1, bits >> 1 & 1, bits >> 2 & 1);
    double share = cloud.coverage(v.x(), v.y(), v.z()) / 255.0;
    for (int e = 0; e < 3; ++e) share *= (bits >> e & 1) ? upper[e] : 1 - upper[e];
    if (!(share > 0)) continue;
    if (touched.tissues) {
      const Tissue& tissue = tissueAt(*touched.tissues, cloud, v);
      ccAddTissue(&sum, share, tissue.stiffness, tissue.damping);
    }
    if (touched.paper) {
      const BaseVectorField& field = *touched.paper->vectors;
      const Vec3 f = field.at(v).toRepresentative;
      const auto tissue = static_cast<std::size_t>(field.tissue(v));
      ccAddVector(&vectors, f.data(), share, ccWeightOf(share, touched.hardness[tissue], 1));
    }
  }
  if (touched.tissues && sum.count > 0)
    touch.spring = KelvinVoigt{sum.stiffness / sum.count, sum.damping / sum.count};
  else if (touched.tissues)
    touch.spring =
        KelvinVoigt{touched.tissues->front().stiffness, touched.tissues->front().damping};
  const double* const f = ccIsPlain(&vectors) ? vectors.plain : vectors.vector;
  if (vectors.count > 0) touch.vector = Vec3(f[0], f[1], f[2]) / vectors.count;
  return touch;
}

}  // namespace cloudcontact
