// Frames and maps of a pair, and the test of separating axes.
#include "contact/pair_frame.h"

#include <algorithm>

#include "law/kernel_solid.h"

namespace cloudcontact {

namespace {

constexpr double kMostMargin = 2;  // [voxels] the band has no planes farther outside
// [voxels] The most that a half-space tells of a depth or a gap, so that floats and the cells of
// hits (kernels/contact/hit_bins.h) have room for it.
constexpr double kDeepest = 1e9;

void rotation(const Eigen::Quaterniond& turn, double scale, float* rows) {
  const Eigen::Matrix3d m = turn.toRotationMatrix() * scale;
  for (int i = 0; i < 9; ++i) rows[i] = static_cast<float>(m(i / 3, i % 3));
}

CcMap mapOf(const Pose& pose, double scaleIn, double scaleOut) {
  CcMap map;
  rotation(pose.orientation, scaleIn / scaleOut, map.turn);
  for (int i = 0; i < 3; ++i) map.shift[i] = static_cast<float>(pose.position[i] / scaleOut);
  return map;
}

Eigen::AlignedBox3d fieldBoxOf(const ContactBody& body) {
  return body.field ? body.field->bounds() : boundsOf(*body.shape);
}

// A half-space has no box: compare with the other box's lowest corner.
bool farFrom(const HalfSpace& plane, const Pose& planePose, const ContactBody& body, double reach) {
  const Eigen::AlignedBox3d box = fieldBoxOf(body);
  const Vec3 normal = body.pose.orientation.conjugate() * (planePose.orientation * plane.normal);
  const double middle =
      plane.normal.dot(planePose.toLocal(body.pose.toWorld(box.center()))) - plane.offset;
  return middle - (box.sizes() / 2).dot(normal.cwiseAbs()) > reach;
}

const HalfSpace* planeOf(const ContactBody& body) {
  return body.shape ? std::get_if<HalfSpace>(body.shape) : nullptr;
}

}  // namespace

Pose gridPose(const Cloud& cloud) {
  return {Eigen::Quaterniond::Identity(), cloud.origin()};
}

Pose toShapeOf(const ContactBody& own, const ContactBody& other) {
  return other.pose.inverse() * own.pose * gridPose(own.field->cloud());
}

std::optional<CcShape> plainShape(const Solid& shape, const Pose& toShape, double voxel) {
  const std::optional<CcSolid> solid = plainSolid(shape);
  if (!solid) return {};
  CcShape s{};
  s.solid = *solid;
  const Eigen::Matrix3d turn = voxel * toShape.orientation.toRotationMatrix();
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) s.toSolid.turn[3 * i + k] = turn(i, k);
    s.toSolid.shift[i] = toShape.position[i];
  }
  if (const auto* const plane = std::get_if<HalfSpace>(&shape)) {
    const double most = kDeepest * voxel;
    s.offset = static_cast<float>(
        std::clamp(plane->offset - plane->normal.dot(toShape.position), -most, most));
    const Vec3 slope = voxel * (toShape.orientation.conjugate() * plane->normal);
    for (int i = 0; i < 3; ++i) {
      s.slope[i] = static_cast<float>(slope[i]);
      s.normal[i] = static_cast<float>(plane->normal[i]);
    }
  }
  return s;
}

CcWay wayOf(const ContactBody& own, const ContactBody& other, const PairFrame& frame) {
  const Cloud& cloud = own.field->cloud();
  const double voxel = cloud.voxelSize();
  const Pose grid = own.pose * gridPose(cloud);
  const Pose toFrame = frame.pose.inverse() * grid;
  const Eigen::Quaterniond fromOther = frame.pose.orientation.conjugate() * other.pose.orientation;
  CcWay way{};
  way.toFrame = mapOf(toFrame, voxel, 1.0);
  rotation(toFrame.orientation, 1, way.frameFromOwn);
  rotation(fromOther, 1, way.frameFromOther);
  rotation(other.pose.orientation.conjugate() * own.pose.orientation, 1, way.turnToOther);
  if (other.shape) return way;
  const Cloud& target = other.field->cloud();
  way.toOther = mapOf((other.pose * gridPose(target)).inverse() * grid, voxel, target.voxelSize());
  return way;
}

PairFrame frameOf(const ContactBody& a, const ContactBody& b) {
  PairFrame frame;
  if (a.field && b.field) {
    const std::size_t na = a.field->sampleCount(), nb = b.field->sampleCount();
    frame.voxel = std::max(a.field->cloud().voxelSize(), b.field->cloud().voxelSize());
    if (na != nb) {
      frame.body = na < nb ? kA : kB;
    } else {
      const Vec3 seenFromA = a.pose.toLocal(b.pose.position),
                 seenFromB = b.pose.toLocal(a.pose.position);
      for (int i = 0; i < 3; ++i) {
        if (seenFromA[i] == seenFromB[i]) continue;
        frame.body = seenFromA[i] > seenFromB[i] ? kA : kB;
        break;
      }
    }
  } else {
    frame.body = a.field ? kA : kB;
    frame.voxel = (a.field ? a : b).field->cloud().voxelSize();
  }
  frame.pose = (frame.body == kA ? a : b).pose;
  return frame;
}

double marginOf(const ContactBody& a, const ContactBody& b, double voxel, double margin) {
  if (planeOf(a) || planeOf(b)) return margin;
  return std::min(margin, kMostMargin * voxel);
}

// Separating axes of two boxes: the normals of their faces and the cross products of their edges.
// (Gottschalk, Lin, Manocha: OBBTree, SIGGRAPH 1996.)
bool farApart(const ContactBody& a, const ContactBody& b, double reach) {
  if (const HalfSpace* const plane = planeOf(a)) return farFrom(*plane, a.pose, b, reach);
  if (const HalfSpace* const plane = planeOf(b)) return farFrom(*plane, b.pose, a, reach);
  const Eigen::AlignedBox3d boxA = fieldBoxOf(a), boxB = fieldBoxOf(b);
  const Vec3 halfA = boxA.sizes() / 2, halfB = boxB.sizes() / 2;
  const Pose bInA = a.pose.inverse() * b.pose;
  const Eigen::Matrix3d turn = bInA.orientation.toRotationMatrix();  // columns: B's axes
  const Vec3 between = bInA.toWorld(boxB.center()) - boxA.center();
  const auto parted = [&](const Vec3& axis) {
    const double spread =
        halfA.dot(axis.cwiseAbs()) + halfB.dot((turn.transpose() * axis).cwiseAbs());
    return std::abs(between.dot(axis)) - spread > reach * axis.norm();
  };
  for (int i = 0; i < 3; ++i)
    if (parted(Vec3::Unit(i)) || parted(turn.col(i))) return true;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      const Vec3 axis = Vec3::Unit(i).cross(turn.col(k));
      if (axis.squaredNorm() > 1e-6 && parted(axis))
        return true;  // otherwise the edges are parallel
    }
  return false;
}

}  // namespace cloudcontact
