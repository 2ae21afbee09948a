// What libsdformat reports, and values that it lets through.
#include "scene/sdf_values.h"

#include <cmath>

namespace cloudcontact::program {

void SdfValues::check(const sdf::Errors& errors, const std::string& element) const {
  if (errors.empty()) return;
  std::string message = errors.front().Message();
  for (char& c : message)
    if (c == '\n') c = ' ';
  if (errors.size() > 1) message += " (and " + std::to_string(errors.size() - 1) + " more)";
  fail(element, message);
}

Vec3 SdfValues::vector(const ignition::math::Vector3d& v, const std::string& element) const {
  const Vec3 out(v.X(), v.Y(), v.Z());
  if (!out.allFinite()) fail(element, "not a finite number; give three finite numbers");
  return out;
}

Pose SdfValues::pose(const ignition::math::Pose3d& p, const std::string& element) const {
  Pose out;
  out.position = vector(p.Pos(), element);
  out.orientation = Eigen::Quaterniond(p.Rot().W(), p.Rot().X(), p.Rot().Y(), p.Rot().Z());
  if (!out.orientation.coeffs().allFinite() || out.orientation.norm() < 0.5)
    fail(element, "not a finite rotation; give six finite numbers");
  out.orientation.normalize();
  return out;
}

Pose SdfValues::resolved(const sdf::SemanticPose& semantic, const std::string& frame,
                         const std::string& element) const {
  ignition::math::Pose3d p;
  check(semantic.Resolve(p, frame), element + " <pose>");
  return pose(p, element + " <pose>");
}

double SdfValues::positive(double value, const std::string& element) const {
  if (!std::isfinite(value) || value <= 0)
    fail(element,
         "must be a positive finite number, is " + std::to_string(value) + "; give one above 0");
  return value;
}

sdf::ElementPtr descend(sdf::ElementPtr element, std::initializer_list<const char*> path) {
  for (const char* name : path) {
    if (!element || !element->HasElement(name)) return nullptr;
    element = element->GetElement(name);
  }
  return element;
}

}  // namespace cloudcontact::program
