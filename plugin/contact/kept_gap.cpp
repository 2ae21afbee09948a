// Both trees are walked at once, the nearer balls first.
#include "contact/kept_gap.h"

#include <cloudcontact/field/surface_field.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "field/ball_tree.h"
#include "field/field_data.h"

namespace cloudcontact {

namespace {

using Node = BallTree::Node;
using V3f = Eigen::Vector3f;

// Balls that are farther apart than this many times the sum of their radii are not divided. So a
// wide gap takes a few balls.
constexpr float kWide = 2;
constexpr double kRounding = 1e-3;  // [voxels] of places, which are numbers of type float

// The balls of two bodies, in A's grid [A's voxels].
class TwoTrees {
 public:
  TwoTrees(const ContactBody& a, const ContactBody& b)
      : a_(ballTree(a.field->data()).nodes()), b_(ballTree(b.field->data()).nodes()) {
    const Cloud &gridA = a.field->cloud(), &gridB = b.field->cloud();
    const Pose toA = a.pose.inverse() * b.pose;
    const double voxel = gridA.voxelSize();
    scale_ = static_cast<float>(gridB.voxelSize() / voxel);
    turn_ = scale_ * toA.orientation.toRotationMatrix().cast<float>();
    shift_ = ((toA.toWorld(gridB.origin()) - gridA.origin()) / voxel).cast<float>();
  }

  bool empty() const { return a_.empty() || b_.empty(); }
  // The least distance of a pair of balls that are not divided further; that of any if one is at
  // most `least`.
  float apart(float least) {
    std::array<Meeting, 2 * 64> stack;  // a tree has at most 33 levels, as it is halved
    std::size_t count = 0;
    float best = std::numeric_limits<float>::infinity();
    stack[count++] = meetingOf(0, 0, placeOf(0));
    while (count > 0) {
      const Meeting at = stack[--count];
      if (!(at.apart < best)) continue;
      const Node &ofA = a_[at.a], &ofB = b_[at.b];
      const float radiusB = scale_ * ofB.radius;
      const bool leaves = ofA.far == 0 && ofB.far == 0;
      if (leaves || at.apart > kWide * (ofA.radius + radiusB)) {
        best = at.apart;
        if (best <= least) break;
        continue;
      }
      const bool dividesA = ofB.far == 0 || (ofA.far > 0 && ofA.radius > radiusB);
      Meeting near = dividesA ? meetingOf(at.a + 1, at.b, at.place)
                              : meetingOf(at.a, at.b + 1, placeOf(at.b + 1)),
              far = dividesA ? meetingOf(ofA.far, at.b, at.place)
                             : meetingOf(at.a, ofB.far, placeOf(ofB.far));
      if (far.apart < near.apart) std::swap(near, far);
      stack[count++] = far;
      stack[count++] = near;
    }
    return best;
  }
  std::size_t compared() const { return compared_; }

 private:
  struct Meeting {
    std::uint32_t a, b;
    float apart;  // negative where the balls meet
    V3f place;    // of B's
  };
  V3f placeOf(std::uint32_t ofB) const { return turn_ * b_[ofB].center + shift_; }
  Meeting meetingOf(std::uint32_t ofA, std::uint32_t ofB, const V3f& place) {
    ++compared_;
    const float between = (a_[ofA].center - place).norm();
    return {ofA, ofB, between - a_[ofA].radius - scale_ * b_[ofB].radius, place};
  }

  const std::vector<Node>&a_, &b_;
  float scale_;
  Eigen::Matrix3f turn_;
  V3f shift_;
  std::size_t compared_ = 0;
};

// A bound on how far the points of a ball have moved from one pose to another. The difference of
// two rotations stretches no vector by more than its Frobenius norm over root two.
double movedBy(const Pose& from, const Pose& to, const Vec3& center, double radius) {
  const Eigen::Matrix3d turn =
      to.orientation.toRotationMatrix() - from.orientation.toRotationMatrix();
  return (turn * center + to.position - from.position).norm() +
         std::sqrt(0.5) * turn.norm() * radius;
}

// A ball around a body, in its own frame.
KeptGap::Side sideOf(const ContactBody& own, const ContactBody& other) {
  const Node& root = ballTree(own.field->data()).nodes().front();
  const Cloud& cloud = own.field->cloud();
  return {cloud.origin() + cloud.voxelSize() * root.center.cast<double>(),
          cloud.voxelSize() * double(root.radius), other.pose.inverse() * own.pose};
}

}  // namespace

void KeptGap::keep(const ContactBody& a, const ContactBody& b, double least) {
  // Balls come nearer and go apart by what the bodies move at most.
  if (kept_ && gap_ <= least && least_ == least && gap_ + moved(a.pose, b.pose) <= least) return;
  drop();
  TwoTrees trees(a, b);
  if (trees.empty()) return;
  const double voxel = a.field->cloud().voxelSize();
  gap_ = voxel * (double(trees.apart(static_cast<float>(least / voxel + kRounding))) - kRounding);
  least_ = least;
  kept_ = true;
  compared_ += trees.compared();
  sides_[0] = sideOf(a, b), sides_[1] = sideOf(b, a);
}

// Of the two bounds on the motion, one in each body's frame, the smaller.
double KeptGap::moved(const Pose& a, const Pose& b) const {
  const Pose now[2] = {b.inverse() * a, a.inverse() * b};
  double least = std::numeric_limits<double>::infinity();
  for (int side = 0; side < 2; ++side) {
    const Side& own = sides_[side];
    least = std::min(least, movedBy(own.inOther, now[side], own.center, own.radius));
  }
  return least;
}

}  // namespace cloudcontact
