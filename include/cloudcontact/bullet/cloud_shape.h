// CloudShape: a cloud as a Bullet collision shape. Concave, may move, may be a compound's child.
#pragma once

#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/law/law.h>

#include <memory>
#include <optional>

namespace cloudcontact {

// The body's frame is the cloud's: Bullet wants the centre of mass at the frame's origin, so
// move the cloud there first (Cloud::translated). One field serves any number of shapes.
class CloudShape : public btConcaveShape {
 public:
  explicit CloudShape(std::shared_ptr<const SurfaceField> field);

  const SurfaceField& field() const { return *field_; }
  // For a cloud that was cut (renewed() in surface_field.h). Between steps; whoever holds the shape
  // (a compound, the world) must be told that its bounds changed. See cuttable_body.h.
  void setField(std::shared_ptr<const SurfaceField> field);

  // The body's own law, which must be valid; empty or Rigid: the body is rigid. Two Kelvin-Voigt
  // bodies, or two Foundations, act in series (inSeries). Any other law needs a rigid body on the
  // other side, because two laws in series are a third: such a pair has no contacts and counts as a
  // failure (CloudContactStatistics).
  std::optional<Law> law;

  void getAabb(const btTransform& t, btVector3& aabbMin, btVector3& aabbMax) const override;
  void setLocalScaling(const btVector3& scaling)
      override;  // only (1,1,1) is accepted: a scaled cloud is another cloud
  const btVector3& getLocalScaling() const override;
  // From the voxels, for a uniform density. Bullet keeps the diagonal alone: where the body's axes
  // are not its principal axes, turn them first (PrincipalFrame).
  void calculateLocalInertia(btScalar mass, btVector3& inertia) const override;
  const char* getName() const override { return "CloudShape"; }
  void setMargin(btScalar margin) override { margin_ = margin; }
  btScalar getMargin() const override { return margin_; }
  // The surface as small squares of two triangles each, for drawing; never used for contact.
  void processAllTriangles(btTriangleCallback* callback, const btVector3& aabbMin,
                           const btVector3& aabbMax) const override;

 private:
  std::shared_ptr<const SurfaceField> field_;
  btScalar margin_ = 0;
};

// The frame in which a cloud's inertia is diagonal, for bodies whose own axes are askew: put the
// CloudShape in a btCompoundShape with the child transform `frame.inverse()`, give the rigid body
// the compound, `frame` as its place in the cloud's frame, and mass * inertiaPerMass.
struct PrincipalFrame {
  btTransform frame;         // from the cloud's frame, at its centre of mass
  btVector3 inertiaPerMass;  // [m^2]
};
PrincipalFrame principalFrame(const Cloud& cloud);

}  // namespace cloudcontact
