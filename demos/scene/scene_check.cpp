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

[[noreturn]] void refuse(const std::string& owner, const char* what, const char* range) {
  throw BadInput((owner.empty() ? "" : owner + ": ") + what + ": must be " + range);
}

void notNegative(const std::string& owner, const char* what, std::optional<double> value) {
  if (value && !(*value >= 0 && std::isfinite(*value)))
    refuse(owner, what, "a finite number of 0 or more");
}

void positive(const std::string& owner, const char* what, std::optional<double> value) {
  if (value && !(*value > 0 && std::isfinite(*value)))
    refuse(owner, what, "a finite number of more than 0");
}

void count(const char* what, std::optional<int> value, int least, int most) {
  if (value && (*value < least || *value > most))
    refuse("", what, ("from " + std::to_string(least) + " to " + std::to_string(most)).c_str());
}

bool isFinite(const Pose& pose) {
  return pose.position.allFinite() && pose.orientation.coeffs().allFinite();
}

bool isFinite(const SceneDrive& drive) {
  return isFinite(drive.place) && drive.linear.allFinite() && drive.angular.allFinite();
}

}  // namespace

void validate(const SceneBody& body) {
  const std::string owner = "body '" + body.name + "'";
  // Bullet's float has no number for the inverse of others.
  constexpr double kLightest = 1e-30, kHeaviest = 1e30;
  if (body.mass && !(*body.mass >= kLightest && *body.mass <= kHeaviest))
    refuse(owner, "mass", "above 0, from 1e-30 to 1e30 kg");
  if (!isFinite(body.pose)) refuse(owner, "pose", "finite");
  if (!body.linearVelocity.allFinite()) refuse(owner, "velocity", "finite");
  if (!body.angularVelocity.allFinite()) refuse(owner, "angular velocity", "finite");
  if (body.drive && !isFinite(*body.drive)) refuse(owner, "drive", "finite");
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
  if (!isFinite(joint.pose)) refuse(owner, "position", "finite");
  if (!joint.axis.allFinite() || joint.axis.norm() < 1e-12)
    refuse(owner, "axis", "finite and not 0");
  if (joint.lower && std::isnan(*joint.lower)) refuse(owner, "lower", "a number");
  if (joint.upper && std::isnan(*joint.upper)) refuse(owner, "upper", "a number");
  if (joint.lower && joint.upper && *joint.lower > *joint.upper)
    refuse(owner, "lower", "at most the upper limit");
  notNegative(owner, "spring", joint.spring);
  notNegative(owner, "damping", joint.damping);
  notNegative(owner, "friction", joint.friction);
  if (!std::isfinite(joint.rest)) refuse(owner, "rest", "finite");
}

void validate(const SceneDescription& scene) {
  const std::string owner = "scene '" + scene.name + "'";
  if (!scene.gravity.allFinite()) refuse(owner, "gravity", "finite");
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
