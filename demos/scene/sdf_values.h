// Numbers, poses and elements of SDFormat files, checked: errors name the file and the element.
#pragma once

#include <cloudcontact/base/pose.h>

#include <ignition/math/Pose3.hh>
#include <initializer_list>
#include <sdf/sdf.hh>
#include <string>
#include <utility>

#include "io/errors.h"

namespace cloudcontact::program {

// Of one file. All throw BadInput with the name of an `element`.
class SdfValues {
 public:
  explicit SdfValues(std::string file) : file_(std::move(file)) {}

  [[noreturn]] void fail(const std::string& element, const std::string& what) const {
    throw BadInput(file_ + ": " + element + ": " + what);
  }
  void check(const sdf::Errors& errors, const std::string& element) const;
  Vec3 vector(const ignition::math::Vector3d& v, const std::string& element) const;
  Pose pose(const ignition::math::Pose3d& p, const std::string& element) const;
  // In the named frame; empty: that which the file says.
  Pose resolved(const sdf::SemanticPose& semantic, const std::string& frame,
                const std::string& element) const;
  double positive(double value, const std::string& element) const;

 private:
  std::string file_;
};

// The element at the end of a path of names, or null. GetElement alone creates missing elements.
sdf::ElementPtr descend(sdf::ElementPtr element, std::initializer_list<const char*> path);

}  // namespace cloudcontact::program
