// Our own method: both bodies digitised with a voxel that is a share of the case's size.
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/voxels/digitize.h>

#include <cmath>
#include <memory>

#include "lab/pair.h"
#include "lab/solids.h"
#include "scene/pair_probe.h"
#include "scene/bullet_methods.h"

namespace cloudcontact::program::lab {
namespace {

constexpr double kFacets =
    0.004;  // [voxels] of a primitive: adds nothing to digitising's own error

struct Side {
  std::shared_ptr<const SurfaceField> field;
  std::optional<Solid> plane;
  std::shared_ptr<btCollisionShape> shape;
  Pose grid;
  double volume = 0;  // [m^3]

  ContactBody at(const Pose& pose) const {
    ContactBody body;
    body.field = field.get();
    body.shape = plane ? &*plane : nullptr;
    body.pose = pose * grid;
    return body;
  }
};

Side sideOf(const LabBody& body, double voxel) {
  Side side;
  if (!body.mesh) {
    side.plane = body.shape;
    side.shape = primitiveShape(*body.shape).shape;
    return side;
  }
  side.grid = body.grid;
  DigitizeSettings settings;
  settings.voxelSize = voxel;
  const Cloud cloud = digitize(moved(body.mesh(kFacets * voxel), body.grid.inverse()), settings);
  side.volume = cloud.massProperties().volume;
  side.field = SurfaceField::build(cloud);
  side.shape = std::make_shared<CloudShape>(side.field);
  return side;
}

// Each point's share of the pair's one spring; what its Kelvin-Voigt force is without damping.
std::vector<LabPoint> pointsOf(const ContactResult& result, double stiffness) {
  std::vector<LabPoint> points;
  for (const ContactPoint& p : result.points)
    if (p.depth > 0) points.push_back({p.position, p.normal, p.depth, p.stiffness / stiffness});
  return points;
}

LabPair pairOf(const std::shared_ptr<const Side>& a, const std::shared_ptr<const Side>& b) {
  const auto finder = std::make_shared<ContactFinder>();
  LabPair pair;
  pair.find = [=](const Pose& pose) {
    ContactSettings settings;
    settings.law = KelvinVoigt{1, 0};
    return pointsOf(finder->find(a->at(Pose{}), b->at(pose), settings), 1);
  };
  pair.microseconds = [=](const Pose& pose, int repeat, double jitter) {
    // The probe has A at the origin: all is seen from A's grid.
    const Pose seen = a->grid.inverse() * pose * b->grid;
    CloudContactSettings law{KelvinVoigt{1e4, 0}};
    law.lists = false;  // nothing is to be answered from memory
    PairProbe probe(*a->shape, *b->shape, seen, Motion{}, Method::Cloud, law);
    return probe.microseconds(repeat, jitter);
  };
  if (!a->plane && !b->plane) pair.volume = a->volume + b->volume;
  pair.swapped = [=] { return pairOf(b, a); };
  return pair;
}

LabPair prepare(const LabBody& a, const LabBody& b, double voxel) {
  return pairOf(std::make_shared<Side>(sideOf(a, voxel)), std::make_shared<Side>(sideOf(b, voxel)));
}

constexpr const char* kTold =
    "both bodies digitised with default settings, their grids turned and shifted at random (six "
    "times for the errors; twice at 1/64; once in the quick mode), contacts with default settings, "
    "in metres as the bodies are; what is timed is Bullet's processCollision on the pair";

}  // namespace

std::vector<LabMethod> cloudMethods() {
  std::vector<LabMethod> methods;
  for (const int parts : {4, 8, 16, 32, 64})
    methods.push_back(
        {"cloud", "voxel = size / " + std::to_string(parts), 1.0 / parts, prepare, kTold});
  return methods;
}

}  // namespace cloudcontact::program::lab
