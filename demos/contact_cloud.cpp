// `contact --method cloud`: the contact in double from ContactFinder, which Bullet's manifolds
// are made of, timed through a Bullet dispatcher as a simulation would call it.
#include <cloudcontact/bullet/cloud_shape.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "contact_report.h"
#include "errors.h"
#include "pair_probe.h"
#include "peers.h"

namespace cloudcontact::program {

namespace {

// A body ready for both: the field or the plane, and its Bullet shape.
struct Side {
  std::shared_ptr<const SurfaceField> field;
  std::optional<AnalyticShape> plane;
  std::shared_ptr<btCollisionShape> shape;

  double voxel() const { return field ? field->cloud().voxelSize() : 0; }
  ContactBody at(const Pose& pose, const Motion& motion) const {
    ContactBody body;
    body.field = field.get();
    body.shape = plane ? &*plane : nullptr;
    body.pose = pose;
    body.motion = motion;
    return body;
  }
};

Side makeSide(const Body& body, double voxel, const CommonOptions& options) {
  Side side;
  if (isHalfSpace(body)) {
    side.plane = body.shape;
    side.shape = primitiveShape(*body.shape).shape;
  } else {
    const Cloud cloud = digitizeBody(body, voxel, options).cloud;
    side.field = buildField(cloud, body.name, options);
    side.shape = std::make_shared<CloudShape>(side.field);
  }
  return side;
}

// One voxel for both bodies, unless a saved cloud brings its own.
double sharedVoxel(const Body& a, const Body& b, const CommonOptions& options) {
  if (options.voxel) return *options.voxel;
  if (isHalfSpace(a)) return defaultVoxel(b);
  if (isHalfSpace(b)) return defaultVoxel(a);
  return std::min(defaultVoxel(a), defaultVoxel(b));
}

ContactReport asReport(const ContactResult& result, const Motion& motionB) {
  ContactReport report;
  for (const ContactPoint& p : result.points)
    report.contacts.push_back({p.position, p.normal, p.depth, p.stiffness, p.damping, p.patch,
                               result.patches[static_cast<std::size_t>(p.patch)].confidence});
  report.patches = result.patches.size();
  report.samples = result.samples;
  report.onB = wrenchOnB(result, Motion{}, motionB);
  return report;
}

}  // namespace

ContactReport cloudContact(const ContactQuery& query, ContactScene* scene) {
  const double voxel = sharedVoxel(query.a, query.b, query.common);
  const Side a = makeSide(query.a, voxel, query.common);
  const Side b = makeSide(query.b, voxel, query.common);
  ContactSettings settings;
  settings.law = query.common.law;
  settings.pair = pairMaterial(query.common);
  ContactFinder finder;
  const ContactResult& result =
      finder.find(a.at(Pose{}, Motion{}), b.at(query.pose, query.motion), settings);
  ContactReport report = asReport(result, query.motion);
  if (scene)
    *scene = {{query.a.name, a.field, a.plane, Pose{}},
              {query.b.name, b.field, b.plane, query.pose},
              result,
              query.motion,
              std::max(a.voxel(), b.voxel())};

  PairProbe probe(*a.shape, *b.shape, query.pose, query.motion, Method::Cloud,
                  {settings.law, settings.pair});
  report.microseconds = probe.microseconds(query.repeat, 1e-3 * voxel);
  return report;
}

}  // namespace cloudcontact::program
