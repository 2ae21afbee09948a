// Inscribed spheres of a cloud.
//
// At each sample of the surface, shrinking finds the largest ball that touches the surface there
// and contains no other sample (Ma, Bae, Choi, "3D medial axis point approximation using nearest
// neighbors and the normal field", 2012): starting from a ball as large as the body, the sample
// nearest to its center defines the next smaller ball through both, until none is inside. Samples
// are right to about 0.01 voxel, which would shrink a ball against its own neighborhood; so samples
// may lie inside by half the tolerance.
//
// The union of all balls is the body. The result takes the largest first, each at a sample that is
// not yet within the tolerance of the union.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include <cloudcontact/objects/sphere_cloud.h>

#include "base/parallel.h"
#include "objects/point_tree.h"
#include "voxels/local_surface.h"

namespace cloudcontact {

namespace {

constexpr int kMostRounds = 40;  // 5 to 10 are usual

// The radius of the largest ball that touches the surface at `place`.
double ballAt(const SurfacePlace& place, const PointTree& tree,
              const std::vector<SurfacePlace>& places, double largest, double slack) {
  double radius = largest;
  for (int round = 0; round < kMostRounds; ++round) {
    const Vec3 center = place.position - radius * place.normal;
    const Vec3& q = places[tree.nearest(center)].position;
    if ((q - center).norm() >= radius - slack) break;
    // The ball through the place and q, tangent at the place.
    const Vec3 away = place.position - q;
    const double along = away.dot(place.normal);
    if (along <= 0) break;
    const double next = away.squaredNorm() / (2 * along);
    if (!(next < radius)) break;
    radius = next;
  }
  return radius;
}

void validate(const InscribedSettings& s) {
  if (!(s.tolerance > 0) || !std::isfinite(s.tolerance))
    throw std::invalid_argument("inscribedSpheres: tolerance must be positive and finite [voxels]");
  if (!(s.smallest > 0) || !std::isfinite(s.smallest))
    throw std::invalid_argument("inscribedSpheres: smallest must be positive and finite [voxels]");
  if (s.perVoxel < 1 || s.perVoxel > 8)
    throw std::invalid_argument("inscribedSpheres: perVoxel must be from 1 to 8");
}

// The distance of each sample from the union of the spheres so far.
class Gaps {
 public:
  explicit Gaps(std::size_t places) : gap_(places, INFINITY) {}
  void addSphere(const Vec3& center, double radius, double reach, const PointTree& tree) {
    tree.forEachWithin(center, radius + reach, [&](std::size_t i, double square) {
      gap_[i] = std::min(gap_[i], std::sqrt(square) - radius);
    });
  }
  double at(std::size_t place) const { return gap_[place]; }

 private:
  std::vector<double> gap_;
};

}  // namespace

SphereCloud inscribedSpheres(const Cloud& cloud, const InscribedSettings& settings,
                             InscribedReport* report) {
  validate(settings);
  const std::vector<SurfacePlace> places =
      surfacePlaces(cloud, settings.perVoxel, settings.threads);
  if (places.empty())
    throw std::invalid_argument("inscribedSpheres: the cloud has no surface; digitize a body");
  std::vector<Vec3> positions;
  Eigen::AlignedBox3d box;
  for (const SurfacePlace& p : places) positions.push_back(p.position), box.extend(p.position);
  const PointTree tree(positions);
  const double h = cloud.voxelSize(), slack = 0.5 * settings.tolerance * h;
  std::vector<double> radius(places.size());
  parallelFor(places.size(), settings.threads, [&](std::size_t i, int) {
    radius[i] = std::max(settings.smallest * h,
                         ballAt(places[i], tree, places, 0.5 * box.diagonal().norm() + h, slack));
  });
  std::vector<std::size_t> order(places.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return radius[a] > radius[b]; });
  SphereCloud spheres;
  spheres.materials = cloud.materials();
  Gaps gaps(places.size());
  for (const std::size_t i : order) {
    if (gaps.at(i) <= settings.tolerance * h) continue;
    const Vec3 center = places[i].position - radius[i] * places[i].normal;
    gaps.addSphere(center, radius[i], 2 * h, tree);
    spheres.centers.push_back(center);
    spheres.radii.push_back(radius[i]);
    if (!spheres.materials.empty()) spheres.material.push_back(places[i].material);
  }
  if (report) {
    *report = {};
    for (std::size_t i = 0; i < places.size(); ++i) {
      report->meanGap += std::max(0.0, gaps.at(i)) / static_cast<double>(places.size());
      report->worstGap = std::max(report->worstGap, gaps.at(i));
      report->worstOverlap = std::max(report->worstOverlap, -gaps.at(i));
    }
  }
  return spheres;
}

}  // namespace cloudcontact
