// `contact --method gjk|gimpact|hacd|primitive`: what Bullet answers for the same pair, with the
// law's k and c shared equally among its points.
#include <algorithm>

#include "commands/contact_report.h"
#include "io/errors.h"
#include "scene/pair_probe.h"
#include "scene/peers.h"

namespace cloudcontact::program {

namespace {

// Facets of a primitive's mesh: finer and Bullet's own mesh methods would be charged for our
// tessellation, coarser and for an error that is not theirs.
constexpr double kFacetTolerance = 0.02;     // [voxels]
constexpr double kHacdFacetTolerance = 0.1;  // [voxels]

double voxelOf(const ContactQuery& query) {
  const auto one = [&](const Body& body) { return isHalfSpace(body) ? 0 : defaultVoxel(body); };
  if (query.common.voxel) return *query.common.voxel;
  const double a = one(query.a), b = one(query.b);
  return a > 0 && b > 0 ? std::min(a, b) : std::max(a, b);
}

PeerShape shapeOf(const Body& body, double voxel, Method method) {
  if (isHalfSpace(body)) return primitiveShape(*body.shape);
  if (method == Method::Primitive) {
    if (body.shape) return primitiveShape(*body.shape);
    throw BadInput("--method primitive: " + body.name +
                   " is not a primitive; give sphere:R, box:X,Y,Z ... or another method");
  }
  // HACD is given coarser primitives still: it would merge their facets for minutes.
  const double tolerance = method == Method::Hacd ? kHacdFacetTolerance : kFacetTolerance;
  const Mesh mesh = meshOf(body, tolerance * voxel);
  if (method == Method::Gimpact) return gimpactShape(mesh);
  return method == Method::Hacd ? convexPartsShape(convexParts(mesh)) : hullShape(mesh);
}

// Kelvin-Voigt at each point, which never pulls: the same force as the clouds' points give.
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

ContactReport peerContact(const ContactQuery& query) {
  const Method method = query.common.method;
  if (method == Method::Sdf)
    throw BadInput("--method sdf: btSdfCollisionShape is not there yet; use cloud or gimpact");
  if (!std::holds_alternative<KelvinVoigt>(query.common.law))
    throw BadInput("--law foundation: needs contact areas; use --method cloud or --law paper");
  const double voxel = voxelOf(query);
  const PeerShape a = shapeOf(query.a, voxel, method), b = shapeOf(query.b, voxel, method);
  PairProbe probe(*a.shape, *b.shape, query.pose, query.motion, method, {});
  ContactReport report;
  int manifold = -1;  // of the point before: a patch is a manifold that touches
  for (const ProbedPoint& p : probe.points()) {
    if (!(p.depth > 0)) continue;  // Bullet also reports points that are only near
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
