// How a Bullet object moves: a rigid body, or a link of a multi-body.
#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <cloudcontact/base/pose.h>

namespace cloudcontact {

// As it is now: without this step's gravity, which Bullet adds in its solver. Any other object
// rests.
Motion motionOf(const btCollisionObject& object);

// By the forces that wait for the step, gravity among them [m/s^2]. None of bodies that contacts do
// not move, and of multi-bodies with a fixed base, for their joints may bear these forces; links on
// a free base fall as the whole does.
Vec3 accelerationOf(const btCollisionObject& object);
// The mean about the object's axes [1/(kg m^2)]; 0 of what nothing turns.
double inverseInertiaOf(const btCollisionObject& object);

// By gravity alone, in worlds that step [m/s^2]. Of multi-bodies as above: they do not know which
// of their forces is gravity.
Vec3 gravityOf(const btCollisionObject& object);

}  // namespace cloudcontact
