// SoftTissue: a deformable body of several tissues, made of a cloud. Its particles (paper, step 1:
// "particle groups express deformable soft tissue") are nodes on a lattice through the cloud, and
// each has the mass and the tissues of the matter around it. Links join them; they have the
// elasticity of the tissues at their ends in series. A btSoftBody of a btSoftRigidDynamicsWorld
// holds them, so clouds touch it as they touch any soft body (soft_contact_point.h), with k and c
// of each node's tissues.
//
// A lattice of links along the edges and the diagonals of the faces of equal cells stretches as an
// isotropic solid of that modulus with a Poisson's ratio of 1/4, which is the only one that it can
// have. The links are solved by backward Euler, so tissue may be as stiff as it likes, and its
// vibrations die out over about as many steps as they take.
#pragma once

#include <LinearMath/btTransform.h>
#include <cloudcontact/bullet/node_matter.h>
#include <cloudcontact/law/tissue.h>
#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/workpiece/collision_finder.h>

#include <memory>
#include <vector>

class btSoftBody;
class btSoftRigidDynamicsWorld;
struct btSoftBodyWorldInfo;

namespace cloudcontact {

// How a cloud becomes nodes and links.
struct SoftTissueSettings {
  // [m] Between nodes, about: a whole number of cells fills the matter's bounds along each axis.
  // Less in thin matter, as cells are nearly cubes. Must be set, to no less than a voxel.
  double spacing = 0;
  double friction = 0;  // m_cfg.kDF, times the other body's
};

// Owns the btSoftBody. Not movable, because Bullet keeps pointers into it.
class SoftTissue {
 public:
  // At rest and undeformed, with the cloud's frame at `place`. `tissues`: one for each of the
  // cloud's materials, or one for all; each needs an elasticity. `info` is the world's. Throws
  // std::invalid_argument, naming the field, where a setting or a tissue does not fit.
  SoftTissue(const Cloud& cloud, const TissueTable& tissues, const btTransform& place,
             btSoftBodyWorldInfo& info, const SoftTissueSettings& settings);
  ~SoftTissue();  // removes it from its world, which must still exist
  SoftTissue(const SoftTissue&) = delete;
  SoftTissue& operator=(const SoftTissue&) = delete;

  // Pin a node by setMass(node, 0). Leave links, faces and the solver's sequences alone.
  btSoftBody& body();
  const btSoftBody& body() const;
  // Use these instead of addSoftBody(): a world steps the links, too.
  void addTo(btSoftRigidDynamicsWorld& world);
  void leaveWorld();

  const TissueTable& tissues() const;
  int nodes() const;
  const NodeMatter& matter(int node) const;
  double elasticEnergy() const;  // [J] of the links
  // [m] How far the links' forces missed their balance in the last step, in the worst node: how
  // far it would have to move.
  double missed() const;

  // Cuts the links that pass through the tool's area, whose frame is at `place`, where `hardness`
  // [Pa] times the tool's ability exceeds the hardness of the tissue there, as a Cutter does
  // (cutter.h), but at once, without a force. Returns how many. Masses and velocities stay as they
  // are; the links' energy is gone. Call it between steps. Throws std::invalid_argument for an
  // invalid area.
  std::size_t cut(const Detection& tool, const Pose& place, double hardness);
  // The parts that hold together: a number for each node, from 0 in the order of their first nodes.
  const std::vector<int>& pieces() const;

  // The surface as it is now, in the world, with that of cuts.
  Mesh surface() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
