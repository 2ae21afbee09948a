// World::State: the Bullet world behind a World, its bodies, joints, tools and what they cut.
#pragma once

#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <cloudcontact/bullet/cloud_contact.h>
#include <cloudcontact/bullet/cuttable_body.h>
#include <cloudcontact/bullet/soft_tissue.h>
#include <cloudcontact/bullet/world_cutter.h>

#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "scene/scene_dispatcher.h"
#include "scene/scene_joints.h"
#include "scene/scene_shapes.h"
#include "scene/world.h"

namespace cloudcontact::program {

struct World::State {
  struct Body {
    SceneBody scene;
    BodyParts parts;                     // frame, mass and inertia follow the cuts
    std::unique_ptr<btRigidBody> own;    // null for a body that can be cut
    std::unique_ptr<CuttableBody> cuts;  // null for others
    // Of the one or the other. Of a body that deforms, `own` follows its center of mass and is not
    // in the world.
    btRigidBody* rigid = nullptr;
    Pose fromFrame;     // parts.frame's inverse
    double volume = 0;  // of a body that can be cut [m^3]
    CutRecord cut = {};
    std::unique_ptr<SoftTissue> soft = {};
    int cutLinks = 0;
    BodyLoad load = {};
    double driveFrom = 0;  // since when a driven body moves as it does, from scene.pose [s]
  };

  struct Joint {
    SceneJoint scene;
    std::unique_ptr<JointConstraint> rows;
  };

  explicit State(const SceneDescription& scene, const WorldSettings& settings);
  ~State();
  void fill(const SceneDescription& scene, const WorldSettings& settings);
  void addBodies(const SceneDescription& scene, const WorldSettings& settings);
  void addBody(const SceneBody& body, BodyParts parts, const WorldSettings& settings);
  void makeRigid(Body& body);
  void sweepFlying();
  void makeCuttable(Body& body);
  void makeSoft(Body& body);
  void holdSides(Body& body, const SceneSoft& soft);
  void followSoft();
  void measureSoft();
  double elasticEnergy() const;
  void takeSoftCuts();
  void softContacts(ContactsNow& now) const;
  void enter(Body& body, bool sleeps);
  void addPiece(std::size_t parent, std::unique_ptr<CuttableBody> piece);
  void followCut(Body& body, const Pose& movedFrame);
  void moveJoints(std::size_t body, const Pose& movedFrame);
  void takeOutcome(std::size_t body, CutOutcome outcome);
  void cut(std::size_t body, std::span<const VoxelCut> cuts);
  void vanish(Body& body);
  void startCutting();
  void cutAfter(double step);
  double cuttableEnergy() const;
  void hold();
  void drive(bool moves);
  void pull();
  void load();
  void setSpring(Body& body, const SceneBody& like);
  void setMass(Body& body, double mass);
  void addJoint(const SceneJoint& joint);
  const Joint& movingAxis(std::size_t joint, std::size_t axis) const;
  void settle(const WorldSettings& settings);
  void noteFrictionless() const;
  void noteSoftOnPlanes() const;
  void look();
  std::vector<std::pair<int, int>> measuredPairs() const;

  // Declared in the order of their lifetimes in Bullet.
  std::unique_ptr<CloudContact> cloudContact;
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  SceneDispatcher dispatcher;
  ModelFilter filter;
  btDbvtBroadphase broadphase;
  // What joints to the world hold. Bullet's own fixed body is one for all worlds of a program, and
  // keeps a list of their joints: worlds made on several threads would break it.
  btRigidBody ground{0, nullptr, nullptr};
  TimedSolver solver;
  std::vector<Body> bodies;
  std::vector<Joint> joints;
  std::set<std::pair<int, int>> joined;
  btSoftRigidDynamicsWorld world;
  WorldCutter cutter;
  ContactMoment moment;
  double latestStep = 0;  // [s]
  double time = 0;        // [s]
  double cutEnergy = 0;   // Energy::cutAway
  Energy softEnergy;      // of the bodies that deform, now
  bool hasTools = false;
  std::vector<BodyPull> pulls = {};
  std::vector<Vec3> pullForces = {};  // in the latest step
  std::vector<Pose> poses;            // of all bodies; empty until needed after a step
};

}  // namespace cloudcontact::program
