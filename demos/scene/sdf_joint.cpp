// A joint, its axis in the world and what moves about it.
#include "scene/sdf_joint.h"

#include <cmath>

namespace cloudcontact::program {

namespace {

// <dynamics>: a spring, its damper and friction.
void readDynamics(const SdfValues& in, const sdf::JointAxis& axis, const std::string& element,
                  SceneJoint& joint) {
  joint.spring = axis.SpringStiffness();
  joint.damping = axis.Damping();
  joint.rest = axis.SpringReference();
  joint.friction = axis.Friction();
  for (const double value : {joint.spring, joint.damping, joint.friction})
    if (!(value >= 0) || !std::isfinite(value))
      in.fail(element + " <dynamics>",
              "<spring_stiffness>, <damping> and <friction> must be 0 or more and finite");
  if (!std::isfinite(joint.rest))
    in.fail(element + " <dynamics>", "<spring_reference> must be finite");
}

}  // namespace

SceneJoint readJoint(
    const SdfValues& in, const sdf::Joint& joint, const std::string& scope, const Pose& modelPose,
    const std::function<int(const std::string& link, const std::string& element)>& bodyOf) {
  SceneJoint out;
  out.name = scope + "::" + joint.Name();
  const std::string element = "joint '" + out.name + "'";
  if (joint.Type() == sdf::JointType::REVOLUTE)
    out.kind = SceneJoint::Kind::Revolute;
  else if (joint.Type() == sdf::JointType::PRISMATIC)
    out.kind = SceneJoint::Kind::Prismatic;
  else if (joint.Type() != sdf::JointType::FIXED)
    in.fail(element, "is of a type not known here; use fixed, revolute or prismatic");
  std::string parent, child;
  in.check(joint.ResolveParentLink(parent), element + " <parent>");
  in.check(joint.ResolveChildLink(child), element + " <child>");
  out.parent = bodyOf(parent, element + " <parent>");
  out.child = bodyOf(child, element + " <child>");
  out.pose = modelPose * in.resolved(joint.SemanticPose(), "__model__", element);
  if (const auto* axis = joint.Axis(0); axis && out.kind != SceneJoint::Kind::Fixed) {
    ignition::math::Vector3d xyz;
    in.check(axis->ResolveXyz(xyz, "__model__"), element + " <axis>");
    const Vec3 local = in.vector(xyz, element + " <axis> <xyz>");
    in.positive(local.norm(), element + " <axis> <xyz>");
    out.axis = (modelPose.orientation * local).normalized();
    const auto limit = descend(axis->Element(), {"limit"});
    if (descend(limit, {"lower"})) out.lower = axis->Lower();
    if (descend(limit, {"upper"})) out.upper = axis->Upper();
    // libsdformat's stand-in for "no limit".
    if (out.lower && *out.lower <= -1e15) out.lower.reset();
    if (out.upper && *out.upper >= 1e15) out.upper.reset();
    readDynamics(in, *axis, element, out);
  }
  return out;
}

}  // namespace cloudcontact::program
