// The contact of one pair by either way. Clouds: in double from ContactFinder, which also fills
// Bullet's manifolds, timed through a Bullet dispatcher as in a simulation; on an OpenCL device
// from a batch of one pair. Bullet's own shapes: its answer, with the law's k and c shared equally
// among its points.
#include "commands/contact_report.h"

#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/device/contact_batch.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "io/both.h"
#include "io/errors.h"
#include "scene/bullet_methods.h"
#include "scene/pair_probe.h"
#include "scene/paper_settings.h"
#include "scene/tissue_file.h"

namespace cloudcontact::program {

namespace {

// A body as field or plane for ContactFinder, and as a Bullet shape.
struct Side {
  std::shared_ptr<const SurfaceField> field;
  std::optional<Solid> plane;
  std::shared_ptr<btCollisionShape> shape;
  std::shared_ptr<CloudShape> cloud;       // `shape`, or null
  const TissueTable* tissues = nullptr;    // in `shape`
  std::shared_ptr<const PaperBody> paper;  // where one of the two states something

  double voxel() const { return field ? field->cloud().voxelSize() : 0; }
  ContactBody at(const Pose& pose, const Motion& motion) const {
    ContactBody body;
    body.field = field.get();
    body.shape = plane ? &*plane : nullptr;
    body.pose = pose;
    body.motion = motion;
    body.tissues = tissues;
    body.paper = paper.get();
    return body;
  }
};

void usePaper(CloudShape& shape, const std::optional<PlacedSolid>& area,
              const PaperOptions& options) {
  PaperSettings settings = paperSettings(options, shape.field().cloud().voxelSize());
  settings.area = area;
  try {
    shape.usePaper(settings);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw BadInput("--window: " + std::string(error.what()));
  }
}

using Field = std::shared_ptr<const SurfaceField>;

Field fieldOf(const Body& body, double voxel, const CommonOptions& options) {
  return buildField(digitizeBody(body, voxel, options).cloud, body.name, options);
}

// The fields of A and B, null for a half-space. Both are built at the same time where they may be:
// each has stretches for one thread. A body pressed on itself is built once.
std::pair<Field, Field> fieldsOf(const ContactQuery& query, double voxel) {
  CommonOptions options = query.common;
  options.backend = Backend::Cpu;  // building the field takes longest, on the CPU
  const auto build = [&](const Body& body, const CommonOptions& how) {
    return isHalfSpace(body) ? nullptr : fieldOf(body, voxel, how);
  };
  if (query.a.name == query.b.name) {
    const Field both = build(query.a, options);
    return {both, both};
  }
  if (!runsBoth(options.threads) || isHalfSpace(query.a) || isHalfSpace(query.b)) {
    Field a = build(query.a, options);
    return {std::move(a), build(query.b, options)};
  }
  const PairProgress progress(options.progress, "finding the surfaces");
  const auto part = [&](int which) {  // digitizing takes a tenth of the time, and has no bar here
    CommonOptions own = options;
    own.progress = [&progress, which](const std::string& label) {
      return label.starts_with("digitizing") ? std::function<void(double)>() : progress.of(which);
    };
    return own;
  };
  return bothOf(
      options.threads, [&] { return build(query.a, part(0)); },
      [&] { return build(query.b, part(1)); });
}

Side makeSide(const Body& body, const Field& field, const std::optional<PlacedSolid>& area,
              const CommonOptions& options, BodyTissues& tissues) {
  Side side;
  if (isHalfSpace(body)) {
    side.plane = body.shape;
    side.shape = primitiveShape(*body.shape).shape;
  } else {
    side.field = field;
    const auto shape = std::make_shared<CloudShape>(side.field);
    shape->setTissues(tissues.of(body.name, field->cloud().materials()));
    if (!shape->tissues().empty()) side.tissues = &shape->tissues();
    if (options.method == Method::Paper) usePaper(*shape, area, options.paper);
    side.shape = side.cloud = shape;
  }
  return side;
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

// Microseconds of each of `repeat` steps of a batch with this pair. Moves B by `jitter` [m] in
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

// The pair's contact on a device; empty, with a message, if the device cannot compute it.
std::optional<ContactReport> onDevice(const BatchPair& pair, const ContactQuery& query,
                                      double jitter) {
  if (pair.a.paper || pair.b.paper || query.common.tissues.given()) {
    reportCpuFallback("stated base vectors and tissues are summed by the CPU");
    return std::nullopt;
  }
  ContactBatch batch({query.common.backend, query.common.threads, false});
  if (batch.backend() != Backend::OpenCl) {
    reportCpuFallback(batch.message());
    return std::nullopt;
  }
  const Span<const BatchPair> one(&pair, 1);
  batch.find(one);  // the first call allocates
  ContactReport report = asReport(*batch.find(one)[0], query.motion);
  if (batch.report().onDevice == 0) {
    reportCpuFallback(
        "the CPU handles near misses, edges of shapes and contacts too large for the device");
    return std::nullopt;
  }
  report.backend = Backend::OpenCl;
  report.microseconds = batchTimes(batch, pair, query.repeat, jitter);
  return report;
}

// The same law for Bullet. With tissues, only its form: k and c are those of the bodies.
std::optional<Law> seamLaw(const Law& law, bool tissues) {
  if (!tissues) return law;
  if (std::holds_alternative<Foundation>(law)) return Foundation{};
  return {};
}

// Tolerance of a primitive's facets. Finer ones slow down Bullet's mesh methods for no gain,
// coarser ones add an error that is not theirs.
constexpr double kFacetTolerance = 0.02;     // [voxels]
constexpr double kHacdFacetTolerance = 0.1;  // [voxels]

BulletShape shapeOf(const Body& body, double voxel, Method method) {
  if (isHalfSpace(body)) return primitiveShape(*body.shape);
  if (method == Method::Primitive) {
    if (body.shape) return primitiveShape(*body.shape);
    throw BadInput("--method primitive: " + body.name +
                   " is not a primitive; give sphere:R, box:X,Y,Z ... or another method");
  }
  // HACD gets coarser primitives, because merging fine facets takes it minutes.
  const double tolerance = method == Method::Hacd ? kHacdFacetTolerance : kFacetTolerance;
  const Mesh mesh = meshOf(body, tolerance * voxel);
  if (method == Method::Gimpact) return gimpactShape(mesh);
  return method == Method::Hacd ? convexPartsShape(convexParts(mesh)) : hullShape(mesh);
}

// Kelvin-Voigt without tension at each point, as for clouds.
Wrench wrenchOf(const std::vector<ReportedContact>& contacts, const Motion& motionB) {
  Wrench sum;
  for (const ReportedContact& c : contacts) {
    const double approach = -c.normal.dot(motionB.at(c.position));
    const Vec3 force = std::max(0.0, c.stiffness * c.depth + c.damping * approach) * c.normal;
    sum.force += force;
    sum.torque += c.position.cross(force);
  }
  return sum;
}

}  // namespace

double sharedVoxel(const ContactQuery& query) {
  const auto one = [&](const Body& body) { return isHalfSpace(body) ? 0 : defaultVoxel(body); };
  if (query.common.voxel) return *query.common.voxel;
  const double a = one(query.a), b = one(query.b);
  return a > 0 && b > 0 ? std::min(a, b) : std::max(a, b);
}

ContactReport cloudContact(const ContactQuery& query, ContactScene* scene) {
  const double voxel = sharedVoxel(query);
  BodyTissues tissues(query.common.tissues);
  const auto [fieldA, fieldB] = fieldsOf(query, voxel);
  Side a = makeSide(query.a, fieldA, query.areaA, query.common, tissues);
  Side b = makeSide(query.b, fieldB, query.areaB, query.common, tissues);
  tissues.check();
  if ((a.cloud && a.cloud->usesPaper()) || (b.cloud && b.cloud->usesPaper()))
    for (Side* const side : {&a, &b})
      if (side->cloud) side->paper = side->cloud->paper();
  ContactSettings settings;
  settings.law = pairLaw(query.common);
  if (query.common.samples) settings.samples = static_cast<std::size_t>(*query.common.samples);
  const BatchPair pair{a.at(Pose{}, Motion{}), b.at(query.pose, query.motion), settings};
  ContactFinder finder;
  const ContactResult& result = finder.find(pair.a, pair.b, settings);
  ContactReport report = asReport(result, query.motion);
  if (scene)
    *scene = {{query.a.name, a.field, a.plane, Pose{}, a.paper},
              {query.b.name, b.field, b.plane, query.pose, b.paper},
              result,
              query.motion,
              std::max(a.voxel(), b.voxel())};

  if (query.common.backend == Backend::OpenCl)
    if (std::optional<ContactReport> device = onDevice(pair, query, 1e-3 * voxel)) return *device;
  CloudContactSettings seam;
  seam.law = seamLaw(settings.law, query.common.tissues.given());
  seam.samples = settings.samples;
  seam.reuseMotion = 0;  // every call searches
  PairProbe probe(*a.shape, *b.shape, query.pose, query.motion, query.common.method, seam);
  report.microseconds = probe.microseconds(query.repeat, 1e-3 * voxel);
  return report;
}

ContactReport bulletContact(const ContactQuery& query) {
  const Method method = query.common.method;
  if (method == Method::Sdf)
    throw BadInput("--method sdf: btSdfCollisionShape is not supported yet; use cloud or gimpact");
  if (!std::holds_alternative<KelvinVoigt>(query.common.law))
    throw BadInput("--law foundation: needs contact areas; use --method cloud or --law paper");
  const double voxel = sharedVoxel(query);
  const BulletShape a = shapeOf(query.a, voxel, method), b = shapeOf(query.b, voxel, method);
  PairProbe probe(*a.shape, *b.shape, query.pose, query.motion, method, {});
  ContactReport report;
  int manifold = -1;  // of the last point; each touching manifold is a patch
  for (const ProbedPoint& p : probe.points()) {
    if (!(p.depth > 0)) continue;  // Bullet also reports points that are merely near
    if (p.manifold != manifold) ++report.patches;
    manifold = p.manifold;
    const int patch = static_cast<int>(report.patches) - 1;
    report.contacts.push_back({p.position, p.normal, p.depth, 0, 0, patch, 1});
  }
  const KelvinVoigt pair = sharedSpring(pairLaw(query.common));
  const double share = report.contacts.empty() ? 0 : 1.0 / double(report.contacts.size());
  for (ReportedContact& c : report.contacts) {
    c.stiffness = share * pair.stiffness;
    c.damping = share * pair.damping;
  }
  report.samples = report.contacts.size();
  report.onB = wrenchOf(report.contacts, query.motion);
  report.microseconds = probe.microseconds(query.repeat, 1e-3 * voxel);
  return report;
}

}  // namespace cloudcontact::program
