// What a contact is: the two bodies, the settings of a query, and its result, which is a list of
// patches with four contact points each. contact_finder.h finds it.
// docs/method.md describes the steps and docs/force.md the sums behind a patch.
#pragma once

#include <cloudcontact/base/wrench.h>
#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/law/law.h>
#include <cloudcontact/law/solid.h>
#include <cloudcontact/law/tissue.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace cloudcontact {

struct PaperBody;  // paper_body.h

// One body of a pair: a cloud's surface field or a shape (exactly one of the two), its pose, and
// its motion. What it points to must outlive the query.
struct ContactBody {
  const SurfaceField* field = nullptr;
  const Solid* shape = nullptr;
  Pose pose;
  Motion motion;
  // What contacts turn the body about, in its own frame [m], and how easily, as its inverse inertia
  // over the other body's; 0: not at all, as what is fixed or driven. Where a patch's points stand
  // follows from them: together where bodies roll, apart where one rests (docs/force.md, "Points").
  Vec3 pivot = Vec3::Zero();
  double inverseInertia = 1;
  // The tissues of the field's cloud, one for each of its materials, or one for all; null: none
  // are stated. If either body has tissues, k and c of a patch are those of the tissues that it
  // touches, (1) and (2), in series over both bodies, and ContactSettings::law gives the form
  // alone. With Foundation the tissues' k and c are per area [N/m^3, N s/m^3].
  const TissueTable* tissues = nullptr;
  std::optional<KelvinVoigt> spring = {};  // of a body without tissues beside one with; none: rigid
  // What its user states of base vectors; null: nothing, and its samples' own are the contact. If
  // either body states something, the direction of a patch's force is that of the sum of the stated
  // vectors over the voxels of either body in the other, (5'), of the bodies that state them.
  const PaperBody* paper = nullptr;
};

// How a contact is searched, and which law shares its force out.
struct ContactSettings {
  Law law = KelvinVoigt{1e4, 0};  // shared out among the points (sharedSpring)
  // [m] Bodies that do not touch but are nearer than this get points with a negative depth where
  // they would touch first. A solver can then stop them within its step. At most two voxels, but
  // for a plane (HalfSpace), which has no limit, and for borders of triangles, as far as the
  // cloud's field knows (about three).
  double margin = 0;
  // The search takes the coarsest of three sample levels that gives this many hits (finer levels
  // need a third of it), or all samples if none does. Fewer hits are faster and less accurate
  // (docs/force.md, "Samples").
  std::size_t samples = kSamples;
  static constexpr std::size_t kSamples = 300;
};

// A point of contact; it becomes one btManifoldPoint.
struct ContactPoint {
  Vec3 position = Vec3::Zero();  // world [m], midway between the two surfaces
  Vec3 normal = Vec3::UnitZ();   // world, unit, from A to B
  double depth = 0;              // [m] positive inside; negative: a gap (ContactSettings::margin)
  double stiffness = 0;          // [N/m] its force without damping, over its depth
  double slope = 0;              // [N/m] how fast that force grows: its share of k
  double damping = 0;            // [N s/m] its share of c
  std::uint32_t id = 0;          // the same from step to step
  int patch = 0;                 // index into ContactResult::patches
};

// Why a patch is not trusted.
enum class Doubt : std::uint8_t { None, FewSamples, Opposed, Deep };

// How a patch's force changes as the bodies move a little (kernels/contact/patch_tangent.h): as
// they come nearer by c along the normal at its center of pressure, and by c + g.x beside it, and A
// slides over B by v; x, g and v are in the patch's plane.
struct PatchTangent {
  Vec3 along[2] = {Vec3::Zero(), Vec3::Zero()};      // the plane's axes, world, unit
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  // x of the area's center [m]
  Eigen::Matrix2d roll = Eigen::Matrix2d::Zero();   // g to how far the points move in the plane [m]
  Eigen::Vector2d aside = Eigen::Vector2d::Zero();  // c to the same, beside moving with the bodies
  Eigen::Matrix2d tilt = Eigen::Matrix2d::Zero();   // g to the turn of the normal
  Eigen::Matrix2d bend = Eigen::Matrix2d::Zero();   // v to the turn of the normal against it [1/m]
  Eigen::Matrix2d lean = Eigen::Matrix2d::Zero();   // x to how the normal leans there [1/m]
  double trustA = 0.5;                              // of A's turn in the normal's; the rest is B's
  double perDepth = 0;  // [1/m] how fast its part of the pair's force grows; 0 of near misses
  double twist = 0;     // A's spin over B to how normals lean around the center of pressure [1/m]
};

// A connected area of contact with one normal and one force.
struct Patch {
  Vec3 position = Vec3::Zero();  // center of pressure, world [m]
  Vec3 normal = Vec3::UnitZ();   // world, from A to B
  double depth = 0;              // [m]
  double stiffness = 0;          // [N/m]
  double damping = 0;            // [N s/m]
  double area = 0;               // [m^2] in contact
  double confidence = 1;         // 0..1
  Doubt doubt = Doubt::None;
  // A near miss of bodies that touch elsewhere (ContactFinder::lookBeside()): it bears nothing yet,
  // and has no part in the pair's depth. Of a contact with patches, one at least is none.
  bool beside = false;
  int firstPoint = 0, points = 0;  // its points in ContactResult::points
  PatchTangent tangent;
};

// What a query finds. Empty: no contact.
struct ContactResult {
  std::vector<Patch> patches;
  std::vector<ContactPoint> points;
  std::size_t samples = 0;  // hits: samples of either body that lie in the other
  int level = 0;            // of the samples that were looked up: 0 all, 1 and 2 fewer
  // [m] Of the pair's depth, by the sums over its hits. depthError() in depth_error.h is more: it
  // also looks for thin walls.
  double depthError = 0;
  // How the area that is in contact falls off with depth (b in docs/force.md, "Depth of the pair"):
  // 0 of faces, 1 of balls and edges, 2 of corners. As the bodies turn about each other,
  // forces move between the points 1 + b times as fast as the points' slopes say.
  double pointed = 0;
  // Memory that it holds.
  std::size_t bytesKept() const {
    return patches.capacity() * sizeof(Patch) + points.capacity() * sizeof(ContactPoint);
  }
  void clear() {
    level = 0;
    depthError = pointed = 0;
    patches.clear();
    points.clear();
    samples = 0;
  }
};

// [m] The pair's depth: that of its patches, weighed by their stiffness; negative: a gap. 0 without
// a contact.
double depthOf(const ContactResult& contact);

// The Kelvin-Voigt force of the points on B, and its torque about the world's origin.
Wrench wrenchOnB(const ContactResult& contact, const Motion& a, const Motion& b);

}  // namespace cloudcontact
