// Soft bodies against clouds. They need CloudContact::attach() on the dispatcher of a
// btSoftRigidDynamicsWorld or btSoftMultiBodyDynamicsWorld, and nothing else.
//
// A soft body's nodes are the paper's points (paper, step 1: "particle groups express deformable
// soft tissue") and the cloud is the workpiece. The pair's law comes from the settings, the shape,
// or the springs of both bodies in series; a soft body states its own, as any object does, by
// setContactStiffnessAndDamping(). k and c are shared out over the nodes by the area of their faces
// or, without faces, by the length of their links; Foundation's k is per area of the faces. Without
// a law, and with Rigid, each node gets an automatic spring. Steps are backward Euler, nodes and
// rigid body together, so a law may be as stiff as it likes.
//
// Where the cloud has tissues (CloudShape::setTissues), or the soft body is a SoftTissue, each node
// has the k and c that it touches, (1) and (2), in series with its own: its D is a cube of a
// voxel's edge. By the paper's method (CloudShape::usePaper) it is pushed
// along the mean of the base vectors of the voxels in that cube, (5'), instead of the fitted
// normal; the cloud's own D and its cutting abilities play no part.
//
// Friction is Coulomb's, with Bullet's coefficient for soft contacts: the soft body's m_cfg.kDF
// times the other's getFriction().
//
// Nodes are points: a soft body's collision margin (0.25 m by default) only widens its box in the
// broad phase. Edges and faces do not touch, so the mesh must be finer than the features that it
// should touch. Links of a multi-body push but are not pushed. Bodies of a
// btDeformableMultiBodyDynamicsWorld count as failures (CloudContactStatistics).
#pragma once

#include <cloudcontact/base/pose.h>

class btCollisionObject;

namespace cloudcontact {

// A node that touched in the last step, or was about to: CloudContact::softContacts().
struct SoftContactPoint {
  int node = 0;
  Vec3 position = Vec3::Zero();              // world, at the step's start [m]
  Vec3 normal = Vec3::UnitZ();               // world, unit, out of the cloud
  double depth = 0;                          // at the step's start [m]; negative: a gap
  Vec3 impulse = Vec3::Zero();               // on the node in this step, friction included [N s]
  const btCollisionObject* other = nullptr;  // the cloud's
};

}  // namespace cloudcontact
