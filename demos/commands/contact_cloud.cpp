// `contact --method cloud`: the contact in double from ContactFinder, which Bullet's manifolds
// are made of, timed through a Bullet dispatcher as a simulation would call it; on an OpenCL device
// from a batch of one pair.
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/device/contact_batch.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>

#include "commands/contact_report.h"
#include "io/errors.h"
#include "scene/pair_probe.h"
#include "scene/peers.h"

namespace cloudcontact::program {

namespace {

// A body ready for both: the field or the plane, and its Bullet shape.
struct Side {
  std::shared_ptr<const SurfaceField> field;
  std::optional<Solid> plane;
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

Side makeSide(const Body& body, double voxel, CommonOptions options) {
  options.backend = Backend::Cpu;  // the field, which takes most of the time, is the CPU's
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

// Microseconds of each of so many steps of a batch of this pair, B elsewhere by `jitter` [m] in
// each.
std::vector<double> batchTimes(ContactBatch& batch, BatchPair pair, int repeat, double jitter) {
  using Clock = std::chrono::steady_clock;
  const Vec3 place = pair.b.pose.position;
  std::vector<double> times;
  for (int k = 0; k < repeat; ++k) {
    pair.b.pose.position = place + jitter * Vec3(k % 3 - 1, k % 5 - 2, k % 7 - 3).normalized();
    const auto start = Clock::now();
    batch.find({&pair, 1});
    times.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count());
  }
  return times;
}

// The pair on a device; nothing, and a message, where that is not to be.
std::optional<ContactReport> onDevice(const BatchPair& pair, const ContactQuery& query,
                                      double jitter) {
  ContactBatch batch({query.common.backend, query.common.threads, false});
  if (batch.backend() != Backend::OpenCl) {
    tellOfCpu(batch.message());
    return std::nullopt;
  }
  const std::span<const BatchPair> one(&pair, 1);
  batch.find(one);  // the first makes room
  ContactReport report = asReport(*batch.find(one)[0], query.motion);
  if (batch.report().onDevice == 0) {
    tellOfCpu("half-spaces, near misses and contacts too large for the device are the CPU's");
    return std::nullopt;
  }
  report.backend = Backend::OpenCl;
  report.microseconds = batchTimes(batch, pair, query.repeat, jitter);
  return report;
}

}  // namespace

ContactReport cloudContact(const ContactQuery& query, ContactScene* scene) {
  const double voxel = sharedVoxel(query.a, query.b, query.common);
  const Side a = makeSide(query.a, voxel, query.common);
  const Side b = makeSide(query.b, voxel, query.common);
  ContactSettings settings;
  settings.law = pairLaw(query.common);
  const BatchPair pair{a.at(Pose{}, Motion{}), b.at(query.pose, query.motion), settings};
  ContactFinder finder;
  const ContactResult& result = finder.find(pair.a, pair.b, settings);
  ContactReport report = asReport(result, query.motion);
  if (scene)
    *scene = {{query.a.name, a.field, a.plane, Pose{}},
              {query.b.name, b.field, b.plane, query.pose},
              result,
              query.motion,
              std::max(a.voxel(), b.voxel())};

  if (query.common.backend == Backend::OpenCl)
    if (std::optional<ContactReport> device = onDevice(pair, query, 1e-3 * voxel)) return *device;
  CloudContactSettings seam;
  seam.law = settings.law;
  seam.lists = false;  // nothing is to be answered from memory
  PairProbe probe(*a.shape, *b.shape, query.pose, query.motion, Method::Cloud, seam);
  report.microseconds = probe.microseconds(query.repeat, 1e-3 * voxel);
  return report;
}

}  // namespace cloudcontact::program
