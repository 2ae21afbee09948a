// Looks up fields and voxels of the bodies at points of the world.
#include "draw/contact_scene.h"

#include <algorithm>
#include <limits>

namespace cloudcontact::program {

namespace {

// By the nearest contact point: points spread over the patch, while its center may lie elsewhere.
int nearestPatch(const Vec3& position, const std::vector<ContactPoint>& points) {
  int best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (const ContactPoint& p : points) {
    const double distance = (p.position - position).squaredNorm();
    if (distance >= least) continue;
    least = distance;
    best = p.patch;
  }
  return best;
}

}  // namespace

std::optional<FieldPoint> PictureBody::at(const Vec3& world) const {
  const Vec3 local = pose.toLocal(world);
  std::optional<FieldPoint> point;
  if (field) {
    point = field->at(local);
  } else {
    const SolidPoint shape = solidAt(*plane, local);
    point = FieldPoint{shape.depth, shape.normal};
  }
  if (point) point->normal = pose.orientation * point->normal;
  return point;
}

// The voxel at a place; the cloud returns 0 for voxels outside of the grid.
static Eigen::Vector3i voxelAt(const Cloud& cloud, const Vec3& local) {
  const Vec3 g = (local - cloud.origin()) / cloud.voxelSize();
  return g.array().floor().max(-1).min(1e9).cast<int>();
}

double PictureBody::coverageAt(const Vec3& world) const {
  const Vec3 local = pose.toLocal(world);
  if (!field) return solidAt(*plane, local).depth > 0 ? 1 : 0;
  const Eigen::Vector3i v = voxelAt(field->cloud(), local);
  return field->cloud().coverage(v.x(), v.y(), v.z()) / 255.0;
}

int PictureBody::materialAt(const Vec3& world) const {
  if (!field) return 0;
  const Eigen::Vector3i v = voxelAt(field->cloud(), pose.toLocal(world));
  return field->cloud().material(v.x(), v.y(), v.z());
}

double PictureBody::detectedDepth(const Vec3& world) const {
  if (paper && paper->area) return depthOf(*paper->area, pose.toLocal(world));
  if (const std::optional<FieldPoint> point = at(world)) return point->depth;
  const double far = std::numeric_limits<double>::infinity();  // from the surface
  return coverageAt(world) > 0.5 ? far : -far;
}

std::optional<PaperVoxel> PictureBody::paperVoxel(const Eigen::Vector3i& voxel, const Vec3& center,
                                                  const PictureBody& other) const {
  const double half = 0.5 * field->cloud().voxelSize();
  if (!paper || !(other.detectedDepth(center) > -half)) return {};
  const BaseVector own = paper->vectors->at({voxel.x(), voxel.y(), voxel.z()});
  return PaperVoxel{center, pose.orientation * own.toRepresentative};
}

std::vector<FoundSample> samplesIn(const PictureBody& own, const PictureBody& other,
                                   const std::vector<ContactPoint>& points) {
  std::vector<FoundSample> found;
  if (!own.field) return found;
  const Cloud& cloud = own.field->cloud();
  for (std::size_t k = 0; k < own.field->sampleCount(); ++k) {
    const SurfaceSample sample = own.field->sample(k);
    const Vec3 grid(sample.position[0], sample.position[1], sample.position[2]);
    const Vec3 world = own.pose.toWorld(cloud.origin() + cloud.voxelSize() * grid);
    const std::optional<FieldPoint> point = other.at(world);
    if (!point || point->depth <= 0) continue;
    const Eigen::Vector3i voxel = grid.array().floor().cast<int>();
    found.push_back({world, voxel, nearestPatch(world, points)});
  }
  return found;
}

double forceOf(const ContactResult& result, int patch) {
  double force = 0;
  for (const ContactPoint& p : result.points)
    if (p.patch == patch) force += p.stiffness * std::max(p.depth, 0.0);
  return force;
}

int mostLoaded(const ContactResult& result) {
  int best = 0;
  for (int k = 1; k < static_cast<int>(result.patches.size()); ++k)
    if (forceOf(result, k) > forceOf(result, best)) best = k;
  return best;
}

}  // namespace cloudcontact::program
