// A force with its torque.
#pragma once

#include <cloudcontact/base/pose.h>

namespace cloudcontact {

// A force [N] and its torque [N m]. Both are in the world frame; each field of this type says about
// which point its torque is taken.
struct Wrench {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
};

}  // namespace cloudcontact
