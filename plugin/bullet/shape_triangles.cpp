// Triangles through btConcaveShape::processAllTriangles().
#include "bullet/shape_triangles.h"

#include <BulletCollision/CollisionShapes/btBox2dShape.h>
#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <BulletCollision/CollisionShapes/btConvex2dShape.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <cmath>

#include "bullet/convert.h"
#include "field/field_data.h"

namespace cloudcontact {

namespace {

// [voxels] Triangles are read in a box that is this much larger than the cloud, or more. Deeper
// than this a sample might find the end of what was read.
constexpr double kAround = 4;
// Of the cloud's largest size: the box's middle and half its sizes lie on a lattice of this width,
// so that a cloud that rests, or moves by less, reads the same triangles.
constexpr double kLattice = 0.25;
constexpr std::size_t kVoters = 64;  // places of the cloud that choose a sheet's side
constexpr int kOutline = 64;         // directions in which a flat shape is asked for its outline

class Collector : public btTriangleCallback {
 public:
  explicit Collector(std::vector<double>& corners) : corners_(corners) {}
  void processTriangle(btVector3* triangle, int, int) override {
    for (int k = 0; k < 3; ++k) append(corners_, triangle[k]);
  }

 private:
  std::vector<double>& corners_;
};

// A fan over the outline of a shape without thickness across z.
void appendFlat(std::vector<double>& corners, const btConvexShape& shape) {
  btVector3 fan[3];
  int count = 0;
  for (int i = 0; i < kOutline; ++i) {
    const double angle = (i + 0.5) * SIMD_2_PI / kOutline;
    const btVector3 corner = shape.localGetSupportingVertex(
        {static_cast<btScalar>(std::cos(angle)), static_cast<btScalar>(std::sin(angle)), 0});
    if (count > 0 && corner == fan[count - 1]) continue;
    fan[count++] = corner;
    if (count < 3) continue;
    for (const btVector3& x : fan) append(corners, x);
    fan[1] = fan[2];
    count = 2;
  }
}

void readTriangles(const btCollisionShape& shape, const Eigen::AlignedBox3d& box,
                   std::vector<double>& corners) {
  corners.clear();
  switch (shape.getShapeType()) {
    case TRIANGLE_SHAPE_PROXYTYPE:
      for (const btVector3& corner : static_cast<const btTriangleShape&>(shape).m_vertices1)
        append(corners, corner);
      return;
    case BOX_2D_SHAPE_PROXYTYPE:
    case CONVEX_2D_SHAPE_PROXYTYPE:
      return appendFlat(corners, static_cast<const btConvexShape&>(shape));
    default:
      Collector collector(corners);
      static_cast<const btConcaveShape&>(shape).processAllTriangles(
          &collector, toBullet(Vec3(box.min())), toBullet(Vec3(box.max())));
  }
}

// The cloud's box as the shape sees it, enlarged to the lattice.
Eigen::AlignedBox3d boxAround(const Eigen::AlignedBox3d& bounds, const Pose& toShape, double voxel,
                              double reach) {
  const double around = kAround * voxel + reach;
  const double cell = std::max(around, kLattice * bounds.sizes().maxCoeff());
  const Vec3 middle = toShape.toWorld(bounds.center());
  const Vec3 half = toShape.orientation.toRotationMatrix().cwiseAbs() * bounds.sizes() / 2;
  const auto nearest = [cell](double x) { return cell * std::round(x / cell); };
  const auto above = [cell](double x) { return cell * std::ceil(x / cell); };
  const Vec3 center = middle.unaryExpr(nearest);
  const Vec3 reached = (half.array() + around + cell / 2).matrix().unaryExpr(above);
  return {Vec3(center - reached), Vec3(center + reached)};
}

// How far a place in the bounds is from where it was, at most.
double farthestMove(const Eigen::AlignedBox3d& bounds, const Pose& now, const Pose& before) {
  double most = 0;
  for (int i = 0; i < 8; ++i) {
    const Vec3 corner = bounds.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i));
    most = std::max(most, (now.toWorld(corner) - before.toWorld(corner)).norm());
  }
  return most;
}

}  // namespace

bool hasTriangles(const btCollisionShape& shape) {
  switch (shape.getShapeType()) {
    case TRIANGLE_SHAPE_PROXYTYPE:
    case BOX_2D_SHAPE_PROXYTYPE:
    case CONVEX_2D_SHAPE_PROXYTYPE:
      return true;
    case STATIC_PLANE_PROXYTYPE:
    case SDF_SHAPE_PROXYTYPE:
      return false;
    case GIMPACT_SHAPE_PROXYTYPE:
      return const_cast<btGImpactShapeInterface&>(
                 static_cast<const btGImpactShapeInterface&>(shape))
                 .getGImpactShapeType() != CONST_GIMPACT_COMPOUND_SHAPE;
    default:
      return shape.isConcave();
  }
}

// By places all over the cloud.
void ShapeTriangles::chooseSides(const Pose& toShape, const SurfaceField& field) {
  const SampleBricks& bricks = field.data().samples().bricks;
  const Cloud& cloud = field.cloud();
  const std::size_t count = bricks.runs.size(), step = 1 + count / kVoters;
  points_.clear();
  for (std::size_t i = 0; i < count; i += step)
    points_.push_back(toShape.toWorld(
        cloud.origin() + cloud.voxelSize() * Vec3(bricks.x[i], bricks.y[i], bricks.z[i])));
  changes_ += surface_->turnTo(points_);
}

const Solid* ShapeTriangles::of(const btCollisionShape& shape, const Pose& pose,
                                const ContactBody& cloud, double reach, std::mutex& reading) {
  const Pose toShape = pose.inverse() * cloud.pose;
  const Eigen::AlignedBox3d box =
      boxAround(cloud.field->bounds(), toShape, cloud.field->cloud().voxelSize(), reach);
  {
    const std::lock_guard lock(reading);
    readTriangles(shape, box, read_);
  }
  const bool changed = !surface_ || read_ != joined_ || !box.isApprox(box_, 0);
  if (changed) {
    std::swap(surface_, before_);
    if (!surface_) surface_ = std::make_shared<TriangleSurface>();
    solid_ = SurfaceSolid{surface_};
    surface_->build(read_, box);
    if (before_) surface_->keepRooms(*before_);
    joined_ = read_;
    box_ = box;
    ++changes_;
  }
  if (surface_->empty()) return nullptr;
  if (changed || cloud.field != chosenBy_ ||
      farthestMove(cloud.field->bounds(), toShape, chosenAt_) >= surface_->turnsAfter()) {
    chooseSides(toShape, *cloud.field);
    chosenAt_ = toShape;
    chosenBy_ = cloud.field;
  }
  return &solid_;
}

}  // namespace cloudcontact
