// A joint, its axis in the world and what moves about it.
#include "scene/sdf_joint.h"

#include <cmath>
#include <map>
#include <numbers>

namespace cloudcontact::program {

namespace {

// <dynamics>: a spring, its damper and friction.
void readDynamics(const SdfValues& in, const sdf::JointAxis& axis, const std::string& element,
                  SceneAxis& joint) {
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

SceneJoint::Kind kindOf(const SdfValues& in, sdf::JointType type, const std::string& element) {
  using Kind = SceneJoint::Kind;
  static const std::map<sdf::JointType, Kind> kinds = {
      {sdf::JointType::FIXED, Kind::Fixed},         {sdf::JointType::REVOLUTE, Kind::Revolute},
      {sdf::JointType::CONTINUOUS, Kind::Revolute}, {sdf::JointType::PRISMATIC, Kind::Prismatic},
      {sdf::JointType::SCREW, Kind::Screw},         {sdf::JointType::BALL, Kind::Ball},
      {sdf::JointType::UNIVERSAL, Kind::Universal}};
  const auto found = kinds.find(type);
  if (found == kinds.end())
    in.fail(element,
            "is of a type not known here; use fixed, revolute, continuous, prismatic, screw, ball "
            "or universal");
  return found->second;
}

// <axis> or <axis2>: where it points, its limits, and what moves along it.
SceneAxis readAxis(const SdfValues& in, const sdf::JointAxis& axis, const Pose& modelPose,
                   bool endless, const std::string& element) {
  SceneAxis out;
  ignition::math::Vector3d xyz;
  in.check(axis.ResolveXyz(xyz, "__model__"), element);
  const Vec3 local = in.vector(xyz, element + " <xyz>");
  in.positive(local.norm(), element + " <xyz>");
  out.axis = (modelPose.orientation * local).normalized();
  readDynamics(in, axis, element, out);
  const auto limit = descend(axis.Element(), {"limit"});
  // libsdformat's stand-ins for "no limit": 1e16 of a place, and of an effort one below 0.
  if (descend(limit, {"lower"}) && axis.Lower() > -1e15 && !endless) out.lower = axis.Lower();
  if (descend(limit, {"upper"}) && axis.Upper() < 1e15 && !endless) out.upper = axis.Upper();
  if (descend(limit, {"effort"}) && axis.Effort() >= 0) out.effort = axis.Effort();
  return out;
}

}  // namespace

SceneJoint readJoint(
    const SdfValues& in, const sdf::Joint& joint, const std::string& scope, const Pose& modelPose,
    const std::function<int(const std::string& link, const std::string& element)>& bodyOf) {
  SceneJoint out;
  out.name = scope + "::" + joint.Name();
  const std::string element = "joint '" + out.name + "'";
  out.kind = kindOf(in, joint.Type(), element);
  std::string parent, child;
  in.check(joint.ResolveParentLink(parent), element + " <parent>");
  in.check(joint.ResolveChildLink(child), element + " <child>");
  out.parent = bodyOf(parent, element + " <parent>");
  out.child = bodyOf(child, element + " <child>");
  out.pose = modelPose * in.resolved(joint.SemanticPose(), "__model__", element);
  const bool endless = joint.Type() == sdf::JointType::CONTINUOUS;
  for (const unsigned i : {0u, 1u}) {
    const sdf::JointAxis* const axis = joint.Axis(i);
    if (!axis || i >= out.axes()) continue;
    const SceneAxis read =
        readAxis(in, *axis, modelPose, endless, element + (i == 0 ? " <axis>" : " <axis2>"));
    (i == 0 ? static_cast<SceneAxis&>(out) : out.second) = read;
  }
  // The format's older meaning: radians a meter, and above 0 a left-handed thread.
  if (out.kind == SceneJoint::Kind::Screw) {
    if (!descend(joint.Element(), {"thread_pitch"}))
      in.fail(element, "a screw without <thread_pitch>; add it, in radians a meter");
    if (joint.ThreadPitch() == 0 || !std::isfinite(joint.ThreadPitch()))
      in.fail(element + " <thread_pitch>", "must be finite and not 0");
    out.pitch = -2 * std::numbers::pi / joint.ThreadPitch();
  }
  return out;
}

}  // namespace cloudcontact::program
