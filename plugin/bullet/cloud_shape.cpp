// Bounds, inertia and drawing of a cloud for Bullet.
#include <BulletCollision/CollisionShapes/btTriangleCallback.h>
#include <LinearMath/btAabbUtil2.h>
#include <cloudcontact/bullet/cloud_shape.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <stdexcept>
#include <typeinfo>
#include <utility>

#include "bullet/cloud_casts.h"
#include "bullet/convert.h"
#include "field/base_vector_bricks.h"
#include "field/closed_form.h"
#include "field/surface_tree.h"
#include "voxels/cut_between.h"

namespace cloudcontact {

namespace {

Eigen::Matrix3d inertiaPerMass(const Cloud& cloud, Vec3* center = nullptr) {
  const MassProperties properties = cloud.massProperties();
  if (center) *center = properties.centerOfMass;
  return properties.inertia / properties.volume;
}

}  // namespace

// Made when it is first asked for: of the field's cloud, or of the body `earlier` that was cut.
struct CloudShape::LazyPaper {
  std::mutex mutex;
  std::shared_ptr<const PaperBody> made;
  std::shared_ptr<const PaperBody> earlier;
  Cloud before;  // its cloud

  // Cuts the base vectors in place where nobody else has them: 0.2 ms for a bite of 250 voxels,
  // where making them takes 70 for a body of 115,000. Null if `after` is no cut of `before`.
  std::shared_ptr<const PaperBody> renewed(const Cloud& after) {
    std::shared_ptr<const PaperBody> old = std::exchange(earlier, nullptr);
    if (!old || !sameGrid(before, after) || !cutsBetween(after, before).empty()) return nullptr;
    PaperBody body = *old;
    const bool alone = old.use_count() == 1;
    old.reset();
    if (!alone || body.vectors.use_count() > 1)
      body.vectors = std::make_shared<BaseVectorField>(
          std::make_unique<BaseVectorField::Bricks>(body.vectors->bricks()));
    std::const_pointer_cast<BaseVectorField>(body.vectors)->cut(cutsBetween(before, after));
    before = Cloud();
    return std::make_shared<PaperBody>(std::move(body));
  }
};

CloudShape::CloudShape(std::shared_ptr<const SurfaceField> field) {
  setField(std::move(field));
  m_shapeType = kCloudType;
  m_collisionMargin = 0;
}

CloudShape::CloudShape(std::shared_ptr<const FieldLevels> levels) {
  if (!levels)
    throw std::invalid_argument("CloudShape: no levels; make a FieldLevels of the body's cloud");
  setLevels(std::move(levels));
  setPaper(std::make_shared<LazyPaper>());
  m_shapeType = kCloudType;
  m_collisionMargin = 0;
}

void CloudShape::setLevels(std::shared_ptr<const FieldLevels> levels) {
  levels_ = std::make_shared<LazyLevels>();
  std::call_once(levels_->once, [&] { levels_->made = std::move(levels); });
}

const FieldLevels& CloudShape::levels() const {
  std::call_once(levels_->once,
                 [&] { levels_->made = std::make_shared<const FieldLevels>(field_); });
  return *levels_->made;
}

const SurfaceField& CloudShape::shownField() const {
  if (field_ || !(fidelity_.tolerance > 0)) return field();
  return *levels().field(levels().coarsest(fidelity_.tolerance / 2));
}

const CloudShape* CloudShape::of(const btCollisionShape& shape) {
  if (shape.getShapeType() != kCloudType) return nullptr;
  // A pair asks ten times a step, and a dynamic cast costs several comparisons.
  if (typeid(shape) == typeid(CloudShape)) return static_cast<const CloudShape*>(&shape);
  return dynamic_cast<const CloudShape*>(&shape);
}

void CloudShape::setPaper(std::shared_ptr<LazyPaper> paper) {
  paper_ = std::move(paper);
  life_ = std::make_shared<int>(0);
}

void CloudShape::setField(std::shared_ptr<const SurfaceField> field) {
  if (!field)
    throw std::invalid_argument("CloudShape: no field; make one with SurfaceField::build");
  auto lazy = std::make_shared<LazyPaper>();
  if (asksPaper_) {
    lazy->earlier = paper_->made ? paper_->made : paper_->earlier;
    lazy->before = paper_->made ? cloud() : paper_->before;
  }
  field_ = std::move(field);
  levels_ = std::make_shared<LazyLevels>();
  recognized_.reset(), solid_.reset();
  setPaper(std::move(lazy));
}

void CloudShape::setTissues(TissueTable tissues) {
  if (!tissues.empty()) validate(tissues);
  const std::size_t materials = std::max<std::size_t>(1, cloud().materials().size());
  if (tissues.size() > 1 && tissues.size() != materials)
    throw std::invalid_argument(
        "CloudShape::setTissues: give one tissue, or one for each of the cloud's materials");
  tissues_ = std::move(tissues);
  setPaper(std::make_shared<LazyPaper>());
}

const RecognizedShape* CloudShape::recognized() const {
  if (fidelity_.exact) return nullptr;
  if (solid_) return &*solid_;
  if (fidelity_.tolerance > 0) return recognized_ ? &*recognized_ : nullptr;
  return field_ ? closedForm(*field_) : nullptr;
}

void CloudShape::setSolid(const PlacedSolid& solid, double voxel) {
  const Solid& kind = solid.solid;
  if (!std::holds_alternative<Sphere>(kind) && !std::holds_alternative<Box>(kind) &&
      !std::holds_alternative<Cylinder>(kind) && !std::holds_alternative<Capsule>(kind) &&
      !std::holds_alternative<Cone>(kind))
    throw std::invalid_argument(
        "CloudShape::setSolid: give a Sphere, Box, Cylinder, Capsule or Cone");
  if (!(voxel >= 0) || !std::isfinite(voxel))
    throw std::invalid_argument("CloudShape::setSolid: voxel must be finite and 0 or more [m]");
  validate(solid);
  solid_ = RecognizedShape{solid, 0};
  solidVoxel_ = voxel;
  life_ = std::make_shared<int>(0);
}

double CloudShape::voxelSize() const {
  if (solid_ && solidVoxel_ > 0) return solidVoxel_;
  return field_ ? field_->cloud().voxelSize() : levels_->made->voxelSize(0);
}

void CloudShape::setFidelity(const Fidelity& fidelity) {
  if (fidelity.budget != 0)
    throw std::invalid_argument(
        "CloudShape::setFidelity: a shape has no budget; give it to CloudContactSettings");
  if (fidelity.exact && fidelity.tolerance != 0)
    throw std::invalid_argument("CloudShape::setFidelity: what is exact has no tolerance");
  if (!(fidelity.tolerance >= 0) || !std::isfinite(fidelity.tolerance))
    throw std::invalid_argument(
        "CloudShape::setFidelity: tolerance must be finite and not negative [m]");
  std::optional<RecognizedShape> found;
  if (fidelity.tolerance != 0 && field_ && !solid_) {
    found = recognizedShape(*field_, fidelity.tolerance);
  } else if (fidelity.tolerance != 0 && !field_) {
    const int level = levels().coarsest(fidelity.tolerance / 2);
    const double off = levels().error(level);
    if (level == 0) field_ = levels().field(0);  // some part needs it; boxes are then its own
    found = recognizedShape(*levels().field(level), fidelity.tolerance - off);
    if (found) found->error += off;
  }
  recognized_ = std::move(found);
  fidelity_ = fidelity;
  recognized();  // finds the closed form now, not in a step
}

void CloudShape::usePaper(const PaperSettings& settings) {
  auto lazy = std::make_shared<LazyPaper>();
  if (states(settings, tissues_))
    lazy->made = std::make_shared<PaperBody>(paperBody(cloud(), tissues_, settings));
  setPaper(std::move(lazy));
  paperSettings_ = settings;
  asksPaper_ = true;
}

void CloudShape::inherit(const CloudShape& whole) {
  law = whole.law;
  tissues_ = whole.tissues_;
  paperSettings_ = whole.paperSettings_;
  asksPaper_ = whole.asksPaper_;
  auto lazy = std::make_shared<LazyPaper>();
  if (asksPaper_ && whole.paper_->made) {
    PaperBody body = *whole.paper_->made;
    body.vectors = std::make_shared<BaseVectorField>(body.vectors->ofPart(cloud()));
    lazy->made = std::make_shared<PaperBody>(std::move(body));
  }
  setPaper(std::move(lazy));
}

std::shared_ptr<const PaperBody> CloudShape::paper() const {
  const std::lock_guard lock(paper_->mutex);
  if (!paper_->made) paper_->made = paper_->renewed(cloud());
  if (!paper_->made)
    paper_->made = std::make_shared<PaperBody>(paperBody(cloud(), tissues_, paperSettings_));
  return paper_->made;
}

// Not by which levels are built: that depends on who asked.
Eigen::AlignedBox3d CloudShape::bounds() const {
  if (field_) return field_->bounds();
  const Vec3 around = Vec3::Constant(fidelity_.tolerance);
  return {levels().bounds().min() - around, levels().bounds().max() + around};
}

void CloudShape::getAabb(const btTransform& t, btVector3& aabbMin, btVector3& aabbMax) const {
  const Eigen::AlignedBox3d box = bounds();
  btTransformAabb(toBullet(Vec3(box.min())), toBullet(Vec3(box.max())), margin_, t, aabbMin,
                  aabbMax);
}

void CloudShape::setLocalScaling(const btVector3& scaling) {
  constexpr btScalar kEven = btScalar(1e-6);  // rounding of a float
  const btScalar factor = scaling.x();
  scaling_ = scaling;
  scalesEvenly_ = factor > 0 && std::isfinite(factor) &&
                  (scaling - btVector3(factor, factor, factor)).length() <= kEven * factor;
  if (!scalesEvenly_ || double(factor) == fieldScaling_) return;
  const double growth = double(factor) / fieldScaling_;
  if (field_) {
    setField(scaled(*field_, growth));
  } else {
    setLevels(std::make_shared<const FieldLevels>(levels_->made, growth));
    recognized_.reset(), solid_.reset();
    setPaper(std::make_shared<LazyPaper>());
  }
  fieldScaling_ = double(factor);
  if (fidelity_.tolerance != 0) setFidelity(fidelity_);
}

void CloudShape::calculateLocalInertia(btScalar mass, btVector3& inertia) const {
  inertia = toBullet(Vec3(mass * inertiaPerMass(cloud()).diagonal()));
}

void CloudShape::processAllTriangles(btTriangleCallback* callback, const btVector3& aabbMin,
                                     const btVector3& aabbMax) const {
  const SurfaceField& seen = shownField();
  if (auto* const ray = dynamic_cast<btTriangleRaycastCallback*>(callback))
    return castRay(seen, getUserIndex(), *ray);
  if (auto* const sweep = dynamic_cast<btTriangleConvexcastCallback*>(callback))
    return castConvex(seen, getUserIndex(), *sweep);
  const Eigen::AlignedBox3d asked(toVec3(aabbMin), toVec3(aabbMax));
  const SurfaceTree& tree = surfaceTree(seen);
  const double anywhere = 1;
  tree.search(
      [&](const Eigen::AlignedBox3d& box) { return box.intersects(asked) ? 0.0 : 2.0; }, anywhere,
      [&](std::uint32_t triangle) {
        const SurfaceTree::Corners corners = tree.corners(triangle);
        btVector3 three[] = {toBullet(corners[0]), toBullet(corners[1]), toBullet(corners[2])};
        if (TestTriangleAgainstAabb2(three, aabbMin, aabbMax))
          callback->processTriangle(three, 0, static_cast<int>(triangle));
      });
}

PrincipalFrame principalFrame(const Cloud& cloud) {
  Vec3 center;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertiaPerMass(cloud, &center));
  Eigen::Matrix3d axes = solver.eigenvectors();
  if (axes.determinant() < 0) axes.col(2) = -axes.col(2);
  return {toBullet(Pose{Eigen::Quaterniond(axes), center}), toBullet(Vec3(solver.eigenvalues()))};
}

}  // namespace cloudcontact
