// CloudShape: a cloud as a Bullet collision shape. Concave; it may move and be a compound's child.
#pragma once

#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/law/law.h>

#include <memory>
#include <optional>

namespace cloudcontact {

// The body's frame is the cloud's. Bullet expects the center of mass at the frame's origin, so move
// the cloud there first (Cloud::translated). Any number of shapes may share a field.
class CloudShape : public btConcaveShape {
 public:
  // Throws std::invalid_argument if `field` is null, as setField() does.
  explicit CloudShape(std::shared_ptr<const SurfaceField> field);

  const SurfaceField& field() const { return *field_; }
  // For a cloud that was cut (renewed() in surface_field.h). Call it between steps, then update the
  // bounds in whatever holds the shape (a compound, the world). CuttableBody does all that.
  void setField(std::shared_ptr<const SurfaceField> field);

  // The body's own law, which must be valid; empty or Rigid: the body is rigid. Two Kelvin-Voigt
  // bodies, or two Foundations, act in series (inSeries). Any other law needs a rigid body on the
  // other side, because two laws in series are a third: such a pair has no contacts and counts as a
  // failure (CloudContactStatistics).
  std::optional<Law> law;

  void getAabb(const btTransform& t, btVector3& aabbMin, btVector3& aabbMax) const override;
  // Throws std::invalid_argument for any scaling but (1, 1, 1).
  void setLocalScaling(const btVector3& scaling) override;
  const btVector3& getLocalScaling() const override;
  // From the voxels, for a uniform density. Bullet keeps the diagonal only: use PrincipalFrame if
  // the cloud's axes are not its principal axes.
  void calculateLocalInertia(btScalar mass, btVector3& inertia) const override;
  const char* getName() const override { return "CloudShape"; }
  void setMargin(btScalar margin) override { margin_ = margin; }
  btScalar getMargin() const override { return margin_; }
  // The surface as small squares of two triangles each. For drawing only, not for contact.
  void processAllTriangles(btTriangleCallback* callback, const btVector3& aabbMin,
                           const btVector3& aabbMax) const override;

 private:
  std::shared_ptr<const SurfaceField> field_;
  btScalar margin_ = 0;
};

// The frame in which a cloud's inertia is diagonal. Put the CloudShape in a btCompoundShape with
// the child transform frame.inverse(), and give the rigid body that compound, the transform
// (cloud's transform) * frame, and the inertia mass * inertiaPerMass.
struct PrincipalFrame {
  btTransform frame;         // in the cloud's frame, at its center of mass
  btVector3 inertiaPerMass;  // [m^2]
};
PrincipalFrame principalFrame(const Cloud& cloud);

}  // namespace cloudcontact
