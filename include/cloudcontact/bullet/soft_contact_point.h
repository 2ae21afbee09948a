// Soft bodies against clouds. CloudContact::attach is all that is needed, on the dispatcher of a
// btSoftRigidDynamicsWorld or btSoftMultiBodyDynamicsWorld; Bullet's own soft-rigid contact knows
// convex shapes only, and passes clouds by.
//
// A soft body's nodes are the paper's points (paper, step 1: "particle groups express deformable
// soft tissue"), the cloud is the workpiece. They touch by the pair's law: the settings', the
// shape's, or the materials of both in series (a soft body states its own as any object does, by
// setContactStiffnessAndDamping). Its k and c are shared out once over the nodes by the area of
// their faces, where there are none by the length of their links; with Foundation k is per
// area of the faces. Where nobody states a law each node gets an automatic spring, with
// Rigid too. Each step is backward Euler, nodes and rigid body together, so a law may be
// as stiff as it likes. Friction is Coulomb's, by the product that Bullet takes of soft contacts:
// m_cfg.kDF of the soft body, getFriction() of the other.
//
// Nodes are points: a soft body's collision margin (0.25 m unless set) makes its broadphase box
// wider, nothing else. Edges and faces do not touch: choose a mesh finer than what it shall feel.
// Links of a multi-body push but are not pushed. Bodies of a btDeformableMultiBodyDynamicsWorld are
// failures (CloudContactStatistics): they move by other rules.
#pragma once

#include <cloudcontact/base/pose.h>

namespace cloudcontact {

// A node that touched in the last step, or was about to: CloudContact::softContacts.
struct SoftContactPoint {
  int node = 0;
  Vec3 position = Vec3::Zero();  // world, as the step began [m]
  Vec3 normal = Vec3::UnitZ();   // world, unit, out of the cloud
  double depth = 0;              // as the step began [m], negative: a gap
  Vec3 impulse = Vec3::Zero();   // that the step gave the node, friction included [N s]
};

}  // namespace cloudcontact
