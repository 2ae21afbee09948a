// OpenVDB's meshToLevelSet: see level_set_peer.h.
#include "level_set_peer.h"

#ifdef CLOUDCONTACT_OPENVDB

#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetMeasure.h>
#include <openvdb/tools/MeshToVolume.h>
#include <tbb/global_control.h>

#include <vector>

struct LevelSetPeer::State {
  tbb::global_control threads;
  openvdb::math::Transform::Ptr transform;
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  openvdb::FloatGrid::Ptr grid;
};

LevelSetPeer::LevelSetPeer(const cloudcontact::Mesh& mesh, double voxelSize, int threads)
    : state_(new State{{tbb::global_control::max_allowed_parallelism, std::size_t(threads)},
                       openvdb::math::Transform::createLinearTransform(voxelSize),
                       {},
                       {},
                       {}}) {
  openvdb::initialize();
  for (const auto& v : mesh.vertices)
    state_->points.emplace_back(float(v[0]), float(v[1]), float(v[2]));
  for (const auto& t : mesh.triangles)
    state_->triangles.emplace_back(unsigned(t[0]), unsigned(t[1]), unsigned(t[2]));
}

LevelSetPeer::~LevelSetPeer() = default;

void LevelSetPeer::build() {
  state_->grid = openvdb::tools::meshToLevelSet<openvdb::FloatGrid>(
      *state_->transform, state_->points, state_->triangles);
}

double LevelSetPeer::volume() const {
  return openvdb::tools::levelSetVolume(*state_->grid);
}

double LevelSetPeer::distance(const cloudcontact::Vec3& at) const {
  const openvdb::tools::GridSampler<openvdb::FloatGrid, openvdb::tools::BoxSampler> sampler(
      *state_->grid);
  return double(sampler.wsSample({at.x(), at.y(), at.z()}));
}

#else

struct LevelSetPeer::State {};

LevelSetPeer::LevelSetPeer(const cloudcontact::Mesh&, double, int) {}
LevelSetPeer::~LevelSetPeer() = default;
void LevelSetPeer::build() {}
double LevelSetPeer::volume() const {
  return 0;
}
double LevelSetPeer::distance(const cloudcontact::Vec3&) const {
  return 0;
}

#endif
