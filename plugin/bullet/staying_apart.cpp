// By boxes, which cost least, then by the gap between the surfaces.
#include "bullet/staying_apart.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <cloudcontact/bullet/cloud_shape.h>

#include <algorithm>
#include <cmath>

#include "bullet/box_gap.h"
#include "bullet/convert.h"
#include "bullet/pair_sweep.h"

namespace cloudcontact {

namespace {

constexpr double kClear = 1.1;  // voxels; a query asks for one, and boxes are rounded
// [voxels] A search sees nothing of clouds that are farther apart: a field has planes up to two
// voxels outside, and planes that go on beyond a corner say root three of the distance.
constexpr double kSeen = 3.6;

}  // namespace

void StayingApart::keep(const PairQuery& query, bool clear) {
  voxel_ = clear ? query.voxel : 0;
  // Shapes of triangles are only what is near, and a level may not see all of its body.
  const double unseen = query.levels.anywhere;
  if (!clear || !query.a.field || !query.b.field || !std::isfinite(unseen)) return gap_.drop();
  if (query.lives[0] != lives_[0] || query.lives[1] != lives_[1]) gap_.drop();
  std::copy_n(query.lives, 2, lives_);
  const double voxel =
      std::max(query.a.field->cloud().voxelSize(), query.b.field->cloud().voxelSize());
  gap_.keep(query.a, query.b, kSeen * voxel + unseen);
}

bool StayingApart::holds(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                         const btDispatcherInfo& info) const {
  if (!(voxel_ > 0)) return false;
  if (boxesStayApart(a, b, kClear * voxel_, double(info.m_timeStep))) return true;
  if (isSwept(a, b, info)) return false;  // it is searched beyond what the gap tells of
  const CloudShape *const ofA = cloudOf(a), *const ofB = cloudOf(b);
  return ofA && ofB && ofA->life() == lives_[0] && ofB->life() == lives_[1] &&
         gap_.holds(toPose(a.getWorldTransform()), toPose(b.getWorldTransform()));
}

}  // namespace cloudcontact
