// CloudShape: a cloud as a Bullet collision shape. Concave; it may move and be a compound's child.
#pragma once

#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <cloudcontact/bullet/fidelity.h>
#include <cloudcontact/contact/paper_body.h>
#include <cloudcontact/field/field_levels.h>
#include <cloudcontact/field/recognized_shape.h>
#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/law/law.h>

#include <memory>
#include <mutex>
#include <optional>

namespace cloudcontact {

struct ShapeRecord;

// The body's frame is the cloud's. Bullet expects the center of mass at the frame's origin, so move
// the cloud there first (Cloud::translated). Any number of shapes may share a field.
//
// Its type is concave, so Bullet's rays, sweeps and drawing call processAllTriangles(). No class of
// Bullet has it, and nothing in Bullet casts to one by it.
class CloudShape : public btConcaveShape {
 public:
  static constexpr int kCloudType = FAST_CONCAVE_MESH_PROXYTYPE;

  // Throws std::invalid_argument if `field` is null, as setField() does.
  explicit CloudShape(std::shared_ptr<const SurfaceField> field);
  // A body whose fields are built when contacts first ask for them. Without a tolerance that is the
  // finest alone. Throws std::invalid_argument if `levels` is null.
  explicit CloudShape(std::shared_ptr<const FieldLevels> levels);
  explicit CloudShape(std::nullptr_t) : CloudShape(std::shared_ptr<const SurfaceField>()) {}

  // The shape as a cloud; null if it is none.
  static const CloudShape* of(const btCollisionShape& shape);

  // Of the finest voxels; a shape made of levels builds it when it is first asked for.
  const SurfaceField& field() const { return field_ ? *field_ : *levels_->made->field(0); }
  const Cloud& cloud() const { return field_ ? field_->cloud() : levels_->made->cloud(); }
  // Its fields of larger voxels: those that it was made of, or made of its field when first asked.
  const FieldLevels& levels() const;
  // For a cloud that was cut (renewed() in surface_field.h). Call it between steps, then update the
  // bounds in whatever holds the shape (a compound, the world). CuttableBody does all that. With a
  // tolerance the body is not recognised as a shape any more: setFidelity() again if it may be one.
  void setField(std::shared_ptr<const SurfaceField> field);

  // The body's own law, which must be valid; empty or Rigid: the body is rigid. Two Kelvin-Voigt
  // bodies, or two Foundations, act in series (inSeries). Any other law needs a rigid body on the
  // other side, because two laws in series are a third: such a pair has no contacts and counts as a
  // failure (CloudContactStatistics).
  std::optional<Law> law;

  // The body's tissues, one for each of the cloud's materials (tissuesOf), or one for all; empty:
  // none. They take the place of `law`: a pair's k and c are those of the tissues that it touches,
  // (1) and (2), in series with the other body's tissues or law. Throws std::invalid_argument as
  // validate(TissueTable) does, and if their number does not fit.
  void setTissues(TissueTable tissues);
  const TissueTable& tissues() const { return tissues_; }

  // A body that is a ball, box, cylinder, capsule, cone or convex body with flat faces, within the
  // tolerance or else the cloud's own error, meets others like it, and Bullet's own, as that shape:
  // same law, far faster. Pairs with a Foundation, stated base vectors or tissues of several
  // materials, and bodies half as deep in each other as they are thick, meet as clouds; so do all
  // where the fidelity is exact. What was cut is no shape. Which shape it is takes 5 to 40 ms to
  // find; this call does, else the first pair.
  //
  // With a tolerance, contacts also take the coarsest voxels whose surface is within half of it
  // (two bodies have one half each), and finer ones where a contact states a larger error
  // (docs/engine.md, "Levels"). A shape made of levels builds the coarsest that holds half the
  // tolerance, and knows shapes by that; without a tolerance it is none. Throws
  // std::invalid_argument where the tolerance is negative or not finite, is given with `exact`, or
  // a budget is given.
  void setFidelity(const Fidelity& fidelity);
  const Fidelity& fidelity() const { return fidelity_; }
  // What rays, sweeps and drawing see: the coarsest field that is within half the tolerance.
  const SurfaceField& shownField() const;
  // The box around its surface, body's frame [m]; of levels, around all matter and the tolerance.
  Eigen::AlignedBox3d bounds() const;
  // What the cloud is within the tolerance, or its own error; null: nothing, or it is exact.
  const RecognizedShape* recognized() const;
  // The voxels were made of this solid: a Sphere, Box, Cylinder, Capsule or Cone. Until the field
  // changes recognized() is that, without a search and exactly. So its voxels, which clouds that
  // are no shape meet, may be coarse: `voxel` [m] is the size by which margins and automatic
  // springs go; 0: that of its voxels. Throws std::invalid_argument for other solids, and a voxel
  // that is negative or not finite.
  void setSolid(const PlacedSolid& solid, double voxel = 0);
  // [m] Of the finest voxels, or what setSolid() said.
  double voxelSize() const;

  // Contacts of this body take their direction from the base vectors that this states: C, Gr, D,
  // membership, hardness and cutting abilities. The other body then has the usual ones, if it
  // states none. Settings that state nothing (states() in paper_body.h) change nothing. Throws as
  // paperBody() does.
  void usePaper(const PaperSettings& settings = {});
  bool usesPaper() const { return asksPaper_ && states(paperSettings_, tissues_); }
  // Its base vectors. They are made when first needed, unless usePaper() was called.
  std::shared_ptr<const PaperBody> paper() const;

  // Law, tissues and the paper's method of a body that this one is a part of, in the same frame and
  // grid. Its base vectors come from the whole's where these are known: 2 ms for 50,000 voxels,
  // where making them takes 40.
  void inherit(const CloudShape& whole);

  // Another one after setField(), setSolid(), setTissues(), usePaper() and inherit(); equal for
  // copies. Contacts that were found before are void then.
  std::shared_ptr<const void> life() const { return life_; }

  void getAabb(const btTransform& t, btVector3& aabbMin, btVector3& aabbMax) const override;
  // A scaling equal along all axes scales the voxels: any that share the field stay as they are.
  // Another one, or one that is not positive, leaves the shape as it is; then scalesEvenly() is
  // false, its pairs have no contacts and count as failures, and diagnose() names the object.
  void setLocalScaling(const btVector3& scaling) override;
  const btVector3& getLocalScaling() const override { return scaling_; }
  bool scalesEvenly() const { return scalesEvenly_; }
  // From the voxels, for a uniform density. Bullet keeps the diagonal only: use PrincipalFrame if
  // the cloud's axes are not its principal axes.
  void calculateLocalInertia(btScalar mass, btVector3& inertia) const override;
  const char* getName() const override { return "CloudShape"; }
  // For Bullet's files: the shape with its field, once for all shapes that share it. CloudImporter
  // (world_importer.h) reads it.
  int calculateSerializeBufferSize() const override;
  const char* serialize(void* buffer, btSerializer* serializer) const override;
  void setMargin(btScalar margin) override { margin_ = margin; }
  btScalar getMargin() const override { return margin_; }
  // Answers Bullet's rays and sweeps from the field (docs/bullet.md, "Queries"). Any other callback
  // gets the surface as triangles, two a surface voxel, counter-clockwise seen from outside.
  void processAllTriangles(btTriangleCallback* callback, const btVector3& aabbMin,
                           const btVector3& aabbMax) const override;

 private:
  friend struct ShapeRecord;
  std::shared_ptr<const SurfaceField> field_;  // null: made of levels_
  struct LazyLevels {
    std::once_flag once;
    std::shared_ptr<const FieldLevels> made;
  };
  std::shared_ptr<LazyLevels> levels_;  // of copies, too
  TissueTable tissues_;
  Fidelity fidelity_;
  std::optional<RecognizedShape> recognized_, solid_;
  double solidVoxel_ = 0;
  PaperSettings paperSettings_;
  bool asksPaper_ = false;
  // Pairs may ask in parallel. Shared, so that the shape stays copyable.
  struct LazyPaper;
  std::shared_ptr<LazyPaper> paper_;
  std::shared_ptr<const int> life_;
  void setPaper(std::shared_ptr<LazyPaper> paper);
  void setLevels(std::shared_ptr<const FieldLevels> levels);
  btScalar margin_ = 0;
  btVector3 scaling_{1, 1, 1};
  double fieldScaling_ = 1;  // of field_
  bool scalesEvenly_ = true;
};

// The frame in which a cloud's inertia is diagonal. Put the CloudShape in a btCompoundShape with
// the child transform frame.inverse(), and give the rigid body that compound, the transform
// (cloud's transform) * frame, and the inertia mass * inertiaPerMass.
struct PrincipalFrame {
  btTransform frame;         // in the cloud's frame, at its center of mass
  btVector3 inertiaPerMass;  // [m^2]
};
// That of a cloud.
PrincipalFrame principalFrame(const Cloud& cloud);

}  // namespace cloudcontact
