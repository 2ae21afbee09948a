// Straight ways through voxels.
#include "contact/way_out.h"

#include <algorithm>
#include <cmath>

#include "field/field_data.h"
#include "law/convex_solid.h"

namespace cloudcontact {

namespace {

constexpr std::size_t kPoints = 96;    // of a cloud, about
constexpr int kTurns = 4;              // of the best direction, each by half of the last
constexpr double kFirstTurn = 0.4;     // [rad]
constexpr std::uint8_t kMatter = 128;  // coverage

// The middles of the faces, edges and corners of a cube, as unit vectors.
const std::vector<Vec3>& directions() {
  static const std::vector<Vec3> all = [] {
    std::vector<Vec3> made;
    for (int sum = 1; sum <= 3; ++sum)
      for (int k = 0; k < 27; ++k) {
        const Vec3 v(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        if (v.cwiseAbs().sum() == sum) made.push_back(v.normalized());
      }
    return made;
  }();
  return all;
}

Eigen::AlignedBox3d boundsOf(const ContactBody& body) {
  return body.field ? body.field->bounds() : cloudcontact::boundsOf(*body.shape);
}

// On the body's surface, and of shapes their middle, too; in its frame.
void appendPoints(const ContactBody& body, std::vector<Vec3>& points) {
  const Vec3 middle = boundsOf(body).center();
  if (body.field) {
    const SampleColumns& samples = body.field->data().samples().levels[kLevels - 1].samples;
    const Cloud& cloud = body.field->cloud();
    const std::size_t stride = 1 + samples.size() / kPoints;
    for (std::size_t k = 0; k < samples.size(); k += stride)
      points.push_back(cloud.origin() +
                       cloud.voxelSize() * Vec3(samples.x[k], samples.y[k], samples.z[k]));
    return;
  }
  points.push_back(middle);
  if (const auto* hull = std::get_if<Hull>(body.shape))
    points.insert(points.end(), hull->corners.begin(), hull->corners.end());
  const Vec3 half = boundsOf(body).sizes() / 2;
  for (const Vec3& way : directions()) {
    if (isSimple(*body.shape)) points.push_back(supportOf(*body.shape, way));
    if (std::holds_alternative<Ellipsoid>(*body.shape))
      points.push_back(middle + half.cwiseProduct(way));
  }
}

bool isBounded(const ContactBody& body) {
  return body.field || (!std::holds_alternative<HalfSpace>(*body.shape) &&
                        !std::holds_alternative<SurfaceSolid>(*body.shape));
}

}  // namespace

bool WayOut::set(const ContactBody& a, const ContactBody& b) {
  const double sizeA = isBounded(a) ? boundsOf(a).diagonal().norm() : HUGE_VAL;
  const double sizeB = isBounded(b) ? boundsOf(b).diagonal().norm() : HUGE_VAL;
  bMoves_ = sizeB < sizeA;
  const ContactBody &moving = bMoves_ ? b : a, &around = bMoves_ ? a : b;
  if (!around.field || !isBounded(moving)) return false;
  field_ = around.field;
  const Pose way = around.pose.inverse() * moving.pose;
  const double reach = boundsOf(moving).diagonal().norm() / 2;
  if (boundsOf(around).exteriorDistance(way.toWorld(boundsOf(moving).center())) > reach / 2)
    return false;
  points_.clear();
  appendPoints(moving, points_);
  const Cloud& cloud = field_->cloud();
  for (Vec3& x : points_) x = (way.toWorld(x) - cloud.origin()) / cloud.voxelSize();
  return true;
}

bool WayOut::inMatter(const Vec3& x) const {
  const Cloud& cloud = field_->cloud();
  const Eigen::Vector3i at = x.array().floor().cast<int>();
  if ((at.array() < 0).any() || (at.array() >= cloud.size().array()).any()) return false;
  return cloud.coverage(at.x(), at.y(), at.z()) >= kMatter;
}

bool WayOut::isInside(const ContactBody& a, const ContactBody& b) {
  if (!set(a, b)) return false;
  if (!(bMoves_ ? b : a).field) return inMatter(points_.front());
  std::size_t inside = 0;
  for (const Vec3& x : points_) inside += inMatter(x);
  return 2 * inside >= points_.size();
}

int WayOut::lengthOf(const Vec3& direction, int most) {
  taken_.assign(static_cast<std::size_t>(most), 0);
  for (const Vec3& x : points_)
    for (int step = 0; step < most; ++step)
      if (!taken_[step] && inMatter(x + step * direction)) taken_[step] = 1;
  return static_cast<int>(std::find(taken_.begin(), taken_.end(), 0) - taken_.begin());
}

void WayOut::turn() {
  double angle = kFirstTurn;
  for (int k = 0; k < kTurns; ++k, angle *= 0.5) {
    const Vec3 side = direction_.unitOrthogonal(), other = direction_.cross(side);
    Vec3 best = direction_;
    for (int i = 0; i < 8; ++i) {
      const double to = i * M_PI / 4;
      const Vec3 tilted = std::cos(to) * side + std::sin(to) * other;
      const Vec3 tried = std::cos(angle) * direction_ + std::sin(angle) * tilted;
      const int steps = lengthOf(tried, steps_);
      if (steps >= steps_) continue;
      steps_ = steps;
      best = tried;
    }
    direction_ = best;
  }
}

void WayOut::write(const ContactBody& a, const ContactBody& b) {
  const ContactBody &moving = bMoves_ ? b : a, &around = bMoves_ ? a : b;
  const Vec3 way = around.pose.orientation * direction_;
  length_ = steps_ * field_->cloud().voxelSize();
  push_.position = moving.pose.toWorld(boundsOf(moving).center());
  push_.normal = bMoves_ ? way : Vec3(-way);
  push_.depth = length_;
}

bool WayOut::find(const ContactBody& a, const ContactBody& b) {
  if (!set(a, b)) return false;
  steps_ = 1 + static_cast<int>(std::ceil(field_->cloud().size().cast<double>().norm()));
  for (const Vec3& tried : directions()) {
    const int steps = lengthOf(tried, steps_);
    if (steps >= steps_) continue;
    steps_ = steps;
    direction_ = tried;
  }
  turn();
  write(a, b);
  return steps_ > 0;
}

bool WayOut::follow(const ContactBody& a, const ContactBody& b) {
  if (!set(a, b)) return false;
  steps_ = lengthOf(direction_, steps_ + 2);
  write(a, b);
  return steps_ > 0;
}

}  // namespace cloudcontact
