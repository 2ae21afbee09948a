// Chooses the cut. Of the planes through the contact that contain its normal, it is the one most
// perpendicular to the surfaces around, which shows their true shapes. On a thread that is the
// plane through the axis, with the profile.
#include "draw/contact_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace cloudcontact::program {

namespace {

constexpr double kNear = 2;                            // a patch's center to its samples [voxels]
constexpr int kCandidates = 24;                        // planes around the normal, over half a turn
constexpr double kLeastHalf = 11, kGreatestHalf = 15;  // half the view's width [voxels]
constexpr double kSquareBonus = 0.02;  // for cuts along the grid, whose voxels show as squares

// Directions of the surfaces around a place: the mean of n n^T.
Eigen::Matrix3d facing(const ContactScene& scene, const Vec3& place, double radius) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  double area = 0;
  for (const PictureBody* body : {&scene.a, &scene.b}) {
    if (!body->field) continue;
    const Cloud& cloud = body->field->cloud();
    const Vec3 center = (body->pose.toLocal(place) - cloud.origin()) / cloud.voxelSize();
    for (std::size_t k = 0; k < body->field->sampleCount(); ++k) {
      const SurfaceSample s = body->field->sample(k);
      const Vec3 at(s.position[0], s.position[1], s.position[2]);
      if ((at - center).norm() * cloud.voxelSize() > radius) continue;
      const Vec3 n = body->pose.orientation * Vec3(s.normal[0], s.normal[1], s.normal[2]);
      sum += s.area * n * n.transpose();
      area += s.area;
    }
  }
  return area > 0 ? Eigen::Matrix3d(sum / area) : sum;
}

// 1 for a plane parallel to a grid plane, down to 0 at 45 deg.
double alongGrid(const ContactScene& scene, const Vec3& across) {
  double best = 0;
  for (const PictureBody* body : {&scene.a, &scene.b}) {
    if (!body->field) continue;
    const double most = (body->pose.orientation.conjugate() * across).cwiseAbs().maxCoeff();
    best = std::max(best, std::pow(most, 8));
  }
  return best;
}

}  // namespace

Focus focusOn(const ContactScene& scene, const std::vector<FoundSample>& found) {
  Focus focus;
  focus.patch = mostLoaded(scene.result);
  const Vec3 center = scene.result.patches[static_cast<std::size_t>(focus.patch)].position;
  Vec3 nearest = center;
  double least = std::numeric_limits<double>::infinity();
  for (const FoundSample& sample : found) {
    const double distance = (sample.position - center).norm();
    if (sample.patch != focus.patch || distance >= least) continue;
    least = distance;
    nearest = sample.position;
  }
  // The center of a ring-shaped patch lies in empty space.
  const bool here = least < kNear * scene.voxel;
  focus.place = here ? center : nearest;
  std::vector<double> distances;
  for (const FoundSample& sample : found)
    if (sample.patch == focus.patch) distances.push_back((sample.position - focus.place).norm());
  std::sort(distances.begin(), distances.end());
  if (!distances.empty()) focus.reach = distances[distances.size() * 9 / 10];
  return focus;
}

CutView closeView(const ContactScene& scene, const Focus& focus, const Rectangle& frame) {
  const Vec3 normal = scene.result.patches[static_cast<std::size_t>(focus.patch)].normal;
  const double half =
      std::clamp(1.3 * focus.reach, kLeastHalf * scene.voxel, kGreatestHalf * scene.voxel);
  const double scale = frame.size().x() / (2 * half);
  // Starts with the axis least along the normal, so that ties go to planes of the world.
  int axis = 0;
  normal.cwiseAbs().minCoeff(&axis);
  const Vec3 side = normal.cross(Vec3::Unit(axis)).normalized();
  const Eigen::Matrix3d faces = facing(scene, focus.place, half);
  Vec3 best = side;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < kCandidates; ++k) {
    const double angle = std::numbers::pi * k / kCandidates;
    const Vec3 across = Eigen::AngleAxisd(angle, normal) * side;
    const double slant = across.dot(faces * across) - kSquareBonus * alongGrid(scene, across);
    if (slant >= least - 1e-9) continue;
    least = slant;
    best = across;
  }
  CutView view = viewAcross(focus.place, best, frame, scale);
  // Off the planes of the grid, where a cut would lie between two voxels.
  view.origin += 1e-3 * scene.voxel * view.across();
  return view;
}

CutView wholeView(const ContactScene& scene, const CutView& cut, const Rectangle& frame) {
  Eigen::AlignedBox2d box;
  for (const PictureBody* body : {&scene.a, &scene.b}) {
    if (!body->field) continue;
    const Eigen::AlignedBox3d bounds = body->field->bounds();
    for (int k = 0; k < 8; ++k) {
      const Vec3 corner = bounds.corner(static_cast<Eigen::AlignedBox3d::CornerType>(k));
      box.extend(cut.direction(body->pose.toWorld(corner) - cut.origin));
    }
  }
  if (cut.scale > 0)
    for (const Point& corner : ringOf(cut.frame))  // contains the close view
      box.extend(Point((corner - cut.frame.center()) / cut.scale));
  CutView view = cut;
  view.frame = frame;
  const Point size = 1.1 * box.sizes();
  view.scale = std::min(frame.size().x() / size.x(), frame.size().y() / size.y());
  const Point middle = box.center();
  view.origin += middle.x() * cut.right - middle.y() * cut.up;
  return view;
}

}  // namespace cloudcontact::program
