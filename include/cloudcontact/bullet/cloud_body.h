// CloudBody: a mesh as a rigid body of Bullet, in one line. It is digitized, weighed, and placed so
// that the mesh appears where the caller puts it.
#pragma once

#include <BulletDynamics/Dynamics/btDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/digitize_settings.h>

#include <memory>
#include <optional>
#include <vector>

namespace cloudcontact {

// How a CloudBody is made of a mesh or a cloud.
struct CloudBodySettings {
  double voxelSize = 0;  // [m] 0: suggestedVoxel() of the mesh. A cloud has its own.
  // [kg] 0: the body is fixed. Empty: as the densities make it.
  std::optional<double> mass = std::nullopt;
  // [kg/m^3] One for each material (the parts of the mesh), or one for all. Of a body with a stated
  // mass only their ratio counts. Tissues bring their own.
  std::vector<double> densities = {1000};
  std::optional<Law> law = std::nullopt;  // CloudShape::law
  TissueTable tissues = {};               // by the names of the materials (tissuesOf); or none
  Fidelity fidelity = {};                 // CloudShape::setFidelity()
  // Given and asked for the mesh's transform, as for a shape whose origin is the mesh's; Bullet's
  // own would get that of the center of mass. It must outlive the body. May be null.
  btMotionState* motionState = nullptr;
  std::size_t maxBytes = DigitizeSettings{}.maxBytes;  // of memory for digitizing
  int threads = 0;                                     // for voxels and fields; 0: all cores
};

// Owns shape and rigid body. Bullet needs the center of mass at the body's origin and a diagonal
// inertia, so the frame of a body that moves is not the mesh's: the mesh is digitized about its
// center of mass, along its principal axes. A fixed body keeps the mesh's frame. CuttableBody is a
// body that can be cut, whose frame follows what is left of it.
class CloudBody {
 public:
  // At rest, the mesh at `place`. From a file: loadMesh(), loadMeshParts() (mesh_file.h); from
  // arrays, Bullet's or Assimp's meshes: meshOf() (mesh.h, striding_mesh.h, assimp_mesh.h). Small
  // holes are closed (report()). Throws std::invalid_argument, naming what is wrong, for a mesh
  // that bounds no volume, has NaN vertices, or has indices of no vertex, for settings
  // that are not finite or negative, and for a `place` that is not rigid (NaN, scaled, mirrored);
  // std::length_error as digitize() does.
  explicit CloudBody(const Mesh& mesh, const btTransform& place = btTransform::getIdentity(),
                     const CloudBodySettings& settings = {});
  // Each part is a material of its own, with its density or tissue.
  explicit CloudBody(const std::vector<NamedMesh>& parts,
                     const btTransform& place = btTransform::getIdentity(),
                     const CloudBodySettings& settings = {});
  // Its voxels stay as they are: where they do not lie along the principal axes, the shape is a
  // child of a compound. `place`, meshToBody() and so on are those of the cloud's frame.
  explicit CloudBody(const Cloud& cloud, const btTransform& place = btTransform::getIdentity(),
                     const CloudBodySettings& settings = {});
  // A field that is made already, or levels of fields; bodies share it. The shape is a child of a
  // compound, and settings.threads and voxelSize are not used. With a field and a tolerance in
  // settings.fidelity, levels are built from its cloud. Throws std::invalid_argument for null.
  explicit CloudBody(std::shared_ptr<const SurfaceField> field,
                     const btTransform& place = btTransform::getIdentity(),
                     const CloudBodySettings& settings = {});
  explicit CloudBody(std::shared_ptr<const FieldLevels> levels,
                     const btTransform& place = btTransform::getIdentity(),
                     const CloudBodySettings& settings = {});
  // Another body of the same matter, at rest, in no world: nothing is digitized again. Without the
  // motion state.
  CloudBody(const CloudBody& like, const btTransform& place);
  ~CloudBody();  // removes it from its world, which must still exist
  CloudBody(CloudBody&& other) noexcept;
  CloudBody& operator=(CloudBody&& other) noexcept;

  btRigidBody& body();
  const btRigidBody& body() const;
  CloudShape& shape();
  const CloudShape& shape() const;
  // How well the mesh bounded a volume; of a cloud, nothing.
  const DigitizeReport& report() const;

  // From the mesh's frame to the body's, and back. The body's transform * meshToBody() draws it.
  btTransform meshToBody() const;
  btTransform bodyToMesh() const;
  btTransform meshPlace() const;                // of the mesh in the world
  void setMeshPlace(const btTransform& place);  // moves the body there, with its velocity

  // In Bullet's groups for moving or fixed bodies, or in the caller's. The world must outlive the
  // body, or the body must leave it first.
  void addTo(btDynamicsWorld& world);
  void addTo(btDynamicsWorld& world, int group, int mask);
  void leaveWorld();
  btDynamicsWorld* world() const;  // null outside a world

 private:
  struct State;
  void make(const Cloud& cloud, CloudShape shape, const btTransform& place,
            const CloudBodySettings& settings);
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
