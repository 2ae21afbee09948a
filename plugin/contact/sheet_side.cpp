// The middle of the matter on a line, in steps of half a voxel.
#include "contact/sheet_side.h"

namespace cloudcontact {

namespace {

constexpr double kSheetStep = 0.5;  // [voxels]
constexpr int kMostSheetSteps = 40;
constexpr int kSheetMatter = 127;  // coverage

// Steps from `x` that stay in matter.
int stepsInside(const Cloud& cloud, Vec3 x, const Vec3& step) {
  int steps = 0;
  while (steps < kMostSheetSteps && isMatter(cloud, x += step)) ++steps;
  return steps;
}

}  // namespace

bool isMatter(const Cloud& cloud, const Vec3& x) {
  const Eigen::Vector3i v = x.array().floor().cast<int>();
  return cloud.coverage(v.x(), v.y(), v.z()) > kSheetMatter;
}

int sideOfSheet(const Cloud& cloud, const Eigen::Vector3f& sample, const Eigen::Vector3f& outward,
                const Vec3& front, double height) {
  const Vec3 inside = (sample - outward).cast<double>();
  if (!isMatter(cloud, inside)) return 0;
  const int up = stepsInside(cloud, inside, kSheetStep * front);
  const int down = stepsInside(cloud, inside, -kSheetStep * front);
  if (up == kMostSheetSteps && down == kMostSheetSteps) return 0;
  const double middle = height - outward.cast<double>().dot(front) +
                        0.5 * kSheetStep * static_cast<double>(up - down);
  return middle < 0 ? -1 : 1;
}

}  // namespace cloudcontact
