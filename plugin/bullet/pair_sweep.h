// PairSweep: continuous collision detection of a pair, for bodies with Bullet's CCD motion
// threshold (btCollisionObject::setCcdMotionThreshold). Where the bodies would move farther against
// each other in a step than this threshold, the pair is asked where it first touches, and gets its
// contacts from there before the step is solved. Unlike Bullet's swept sphere this is exact to a
// twentieth of a voxel for bodies of any shape, and includes their spin.
//
// A cloud in a compound is swept only if Bullet asks for the child's pair at the step's start.
#pragma once

#include "bullet/pair_query.h"
#include "contact/first_touch.h"

struct btDispatcherInfo;

namespace cloudcontact {

// The least threshold of the bodies that can move [m]; infinite: none has one.
double sweptFrom(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b);
// Whether a body of the pair that can move has a threshold, and the bodies move farther against
// each other in the step.
bool isSwept(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
             const btDispatcherInfo& info);

class PairSweep {
 public:
  PairSweep(std::shared_ptr<ContactWorkspace> workspace, std::mutex& reading)
      : touch_(std::move(workspace)), reading_(reading) {}

  // Where the bodies of a query first touch within a step; empty if they do not. The query may be
  // `apart`.
  std::optional<Touch> find(const PairQuery& query, const btCollisionObjectWrapper& a,
                            const btCollisionObjectWrapper& b, double step);

 private:
  std::optional<Touch> throughTriangles(ContactBody a, ContactBody b,
                                        const btCollisionShape& triangles, double step);

  FirstTouch touch_;
  ShapeTriangles triangles_;
  std::mutex& reading_;
};

}  // namespace cloudcontact
