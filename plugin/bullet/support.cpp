// Support, seen along the pull: the center lies inside the convex hull of what bears.
#include "bullet/support.h"

#include <vector>

namespace cloudcontact {

namespace {

// Cosine of 75 deg: walls bear no weight.
constexpr double kBears = 0.26;

// Whether the origin lies inside the convex hull of the points, by `inside` or more. Walks
// around the hull (Jarvis, Information Processing Letters 2, 1973): from a corner to that from
// which all others lie to the left.
bool isAround(const std::vector<Eigen::Vector2d>& points, double inside) {
  const auto left = [](const Eigen::Vector2d& way, const Eigen::Vector2d& to) {
    return way.x() * to.y() - way.y() * to.x();
  };
  std::size_t at = 0;
  for (std::size_t i = 1; i < points.size(); ++i)
    if (points[i].x() < points[at].x()) at = i;
  const std::size_t first = at;
  for (std::size_t corners = 0; corners < points.size(); ++corners) {
    std::size_t next = at;
    Eigen::Vector2d way(0, 0);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d to = points[i] - points[at];
      const double side = left(way, to);
      if (side < 0 || (side == 0 && to.squaredNorm() > way.squaredNorm())) next = i, way = to;
    }
    if (left(way, -points[at]) < inside * way.norm() || next == at) return false;
    at = next;
    if (at == first) return corners >= 2;
  }
  return false;
}

}  // namespace

bool holdsWeight(const PairQuery& query, const ContactResult& found, double least, double inside) {
  const Vec3 pull = query.pull[0] - query.pull[1];
  if (!(pull.norm() > 0)) return true;
  const Vec3 down = pull.normalized();
  const Vec3 center = (query.pull[0].isZero() ? query.b : query.a).motion.center;
  const Vec3 aside = down.unitOrthogonal(), across = down.cross(aside);
  std::vector<Eigen::Vector2d> arms;
  for (const ContactPoint& point : found.points) {
    if (!(point.depth > least && point.normal.dot(down) > kBears)) continue;
    const Vec3 arm = point.position - center;
    arms.emplace_back(aside.dot(arm), across.dot(arm));
  }
  return isAround(arms, inside);
}

}  // namespace cloudcontact
