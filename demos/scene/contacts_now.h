// The contacts of a world as they stand between two steps, whatever method found them.
#pragma once

#include <btBulletDynamicsCommon.h>
#include <cloudcontact/base/pose.h>

#include <cstddef>
#include <span>
#include <vector>

namespace cloudcontact::program {

// One point. `force` is what the solver let body a press on body b with during the latest step,
// friction with it, as a mean over that step [N].
struct ContactNow {
  Vec3 position = Vec3::Zero();  // midway between the surfaces, moved on with the bodies [m]
  Vec3 normal = Vec3::UnitZ();   // from a to b
  Vec3 force = Vec3::Zero();
  double depth = 0;  // [m] positive inside, at the step's start
};

// One manifold: with clouds a patch of the pair's contact.
struct PatchNow {
  int a = -1, b = -1;                 // btCollisionObject::getUserIndex
  std::size_t first = 0, points = 0;  // of all points
};

struct ContactsNow {
  std::vector<PatchNow> patches;
  std::vector<ContactNow> points;  // of all patches, in their order

  std::span<const ContactNow> of(const PatchNow& patch) const {
    return {points.data() + patch.first, patch.points};
  }
};

// `step` is the latest step's length [s]: impulses become forces by it. `now` is filled anew; one
// that is used again allocates nothing.
void findContactsNow(btDispatcher& dispatcher, double step, ContactsNow& now);

}  // namespace cloudcontact::program
