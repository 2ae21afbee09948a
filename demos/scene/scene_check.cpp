// Checks of scenes and settings (scene_check.h). The readers of files and options have checked
// theirs; what a program makes by hand comes here first.
#include "scene/scene_check.h"

#include <cmath>
#include <optional>
#include <string>

#include "io/errors.h"
#include "scene/world.h"

namespace cloudcontact::program {
namespace {

// Bullet's float has no number for the inverse of smaller ones, nor for larger ones.
constexpr double kLeast = 1e-30, kMost = 1e30;

[[noreturn]] void refuse(const std::string& owner, const char* what, const char* range) {
  throw BadInput((owner.empty() ? "" : owner + ": ") + what + ": must be " + range);
}

void notNegative(const std::string& owner, const char* what, std::optional<double> value) {
  if (value && !(*value >= 0 && *value <= kMost))
    refuse(owner, what, "a number of 0 or more, up to 1e30");
}

void positive(const std::string& owner, const char* what, std::optional<double> value) {
  if (value && !(*value > 0 && *value <= kMost))
    refuse(owner, what, "a number of more than 0, up to 1e30");
}

void count(const char* what, std::optional<int> value, int least, int most) {
  if (value && (*value < least || *value > most))
    refuse("", what, ("from " + std::to_string(least) + " to " + std::to_string(most)).c_str());
}

bool isUsable(const Vec3& v) {
  return v.allFinite() && v.cwiseAbs().maxCoeff() <= kMost;
}

bool isUsable(const Pose& pose) {
  return isUsable(pose.position) && pose.orientation.coeffs().allFinite();
}

bool isUsable(const SceneDrive& drive) {
  return isUsable(drive.place) && isUsable(drive.linear) && isUsable(drive.angular);
}

constexpr const char* kFinite = "finite, and at most 1e30";

void checkAxis(const std::string& owner, const SceneAxis& axis) {
  if (!axis.axis.allFinite() || axis.axis.norm() < 1e-12) refuse(owner, "axis", "finite and not 0");
  if (axis.lower && std::isnan(*axis.lower)) refuse(owner, "lower", "a number");
  if (axis.upper && std::isnan(*axis.upper)) refuse(owner, "upper", "a number");
  if (axis.lower && axis.upper && *axis.lower > *axis.upper)
    refuse(owner, "lower", "at most the upper limit");
  notNegative(owner, "spring", axis.spring);
  notNegative(owner, "damping", axis.damping);
  notNegative(owner, "friction", axis.friction);
  if (!std::isfinite(axis.rest)) refuse(owner, "rest", "finite");
  if (!(axis.effort >= 0)) refuse(owner, "effort", "0 or more");
}

}  // namespace

void validate(const SceneBody& body) {
  const std::string owner = "body '" + body.name + "'";
  if (body.mass && !(*body.mass >= kLeast && *body.mass <= kMost))
    refuse(owner, "mass", "above 0, from 1e-30 to 1e30 kg");
  if (body.inertia && !(body.inertia->allFinite() && body.inertia->cwiseAbs().maxCoeff() <= kMost))
    refuse(owner, "inertia", kFinite);
  if (!isUsable(body.pose)) refuse(owner, "pose", kFinite);
  if (!isUsable(body.linearVelocity)) refuse(owner, "velocity", kFinite);
  if (!isUsable(body.angularVelocity)) refuse(owner, "angular velocity", kFinite);
  if (body.drive && !isUsable(*body.drive)) refuse(owner, "drive", kFinite);
  notNegative(owner, "friction", body.friction);
  positive(owner, "stiffness", body.stiffness);
  notNegative(owner, "damping", body.damping);
  if (body.restitution && !(*body.restitution >= 0 && *body.restitution <= 1))
    refuse(owner, "restitution", "from 0 to 1");
  for (const SceneCollision& collision : body.collisions)
    if (collision.cutter) notNegative(owner, "ability", collision.cutter->ability);
}

void validate(const SceneJoint& joint) {
  const std::string owner = "joint '" + joint.name + "'";
  if (joint.parent == joint.child) refuse(owner, "parent", "another body than the child");
  if (!isUsable(joint.pose)) refuse(owner, "position", kFinite);
  checkAxis(owner, joint);
  if (joint.kind == SceneJoint::Kind::Screw && !(std::abs(joint.pitch) > 0))
    refuse(owner, "pitch", "not 0");
  if (!std::isfinite(joint.pitch)) refuse(owner, "pitch", kFinite);
  if (joint.kind != SceneJoint::Kind::Universal) return;
  checkAxis(owner + ", second axis", joint.second);
  if (std::abs(joint.axis.normalized().dot(joint.second.axis.normalized())) > 0.01)
    refuse(owner, "second axis", "across the first");
}

void validate(const SceneDescription& scene) {
  const std::string owner = "scene '" + scene.name + "'";
  if (!isUsable(scene.gravity)) refuse(owner, "gravity", kFinite);
  positive(owner, "step", scene.step);
  for (const SceneBody& body : scene.bodies) validate(body);
  for (const SceneJoint& joint : scene.joints) validate(joint);
}

void validate(const WorldSettings& settings) {
  const CommonOptions& o = settings.common;
  notNegative("", "friction", o.friction);
  positive("", "shell", o.shell);
  notNegative("", "reuse", o.reuse);
  notNegative("", "tolerance", o.tolerance);
  count("samples", o.samples, 1, 1000000000);
  count("iterations", settings.iterations, 1, 100000);
  count("threads", o.threads, 0, 1024);
}

}  // namespace cloudcontact::program
