// The error by the sums is ccDepthError() in kernels/contact/contact_error.h. A wall that is too
// thin for the fit of its voxels does not show in them: it is looked up, one voxel below the
// surface of the heaviest patch.
#include <cloudcontact/contact/depth_error.h>

#include <algorithm>
#include <cmath>

namespace cloudcontact {

namespace {

// [voxels] A wall thinner than this is not fitted well. Its depth is off by kPerThinness for each
// voxel that it lacks.
constexpr double kWall = 1.2, kPerThinness = 0.8;
constexpr double kFacing = 0.3;  // cosine of a wall's side to the patch, at least
constexpr double kBand = 4;      // [voxels] a field knows its surface this deep

// [m] By how much the depth may be off because the body is thin below `point`, seen against
// `outward`. The middle of a patch that is a ring is not on its surface: nothing is known there.
double thinness(const ContactBody& body, const Vec3& point, const Vec3& outward, double depth) {
  if (!body.field || depth > kBand * body.field->cloud().voxelSize()) return 0;
  const double voxel = body.field->cloud().voxelSize();
  double below = std::max(0.0, 0.5 * depth);  // the body's own surface
  const auto facing = [&](const FieldPoint& p) {
    return (body.pose.orientation * p.normal).dot(outward);
  };
  auto found = body.field->at(body.pose.toLocal(point));
  if (!found || std::abs(facing(*found)) < kFacing) return 0;
  if (facing(*found) > 0) {
    found = body.field->at(body.pose.toLocal(point - voxel * outward));
    below += voxel;
    if (found && facing(*found) > -kFacing) return 0;
  }
  const double thickness = found ? found->depth + below : 0;
  return kPerThinness * std::max(0.0, kWall * voxel - thickness);
}

double forceOf(const Patch& patch) {
  return patch.stiffness * patch.depth;
}

}  // namespace

double depthError(const ContactBody& a, const ContactBody& b, const ContactResult& contact) {
  if (contact.patches.empty()) return 0;
  const Patch& heaviest =
      *std::max_element(contact.patches.begin(), contact.patches.end(),
                        [](const Patch& x, const Patch& y) { return forceOf(x) < forceOf(y); });
  const Vec3 &at = heaviest.position, &n = heaviest.normal;
  return contact.depthError +
         std::max(thinness(a, at, n, heaviest.depth), thinness(b, at, -n, heaviest.depth));
}

}  // namespace cloudcontact
