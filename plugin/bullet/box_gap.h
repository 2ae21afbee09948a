// Pairs that Bullet's wide boxes report but that cannot touch in a step: their own boxes tell, at a
// fraction of what a query costs.
#pragma once

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

namespace cloudcontact {

// Whether the world's boxes of the two shapes are farther apart than `reach` [m] and than their
// motion, with the forces that wait, brings them together in a step of `step` seconds. False where
// a number is not finite.
bool boxesStayApart(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                    double reach, double step);

// Whether these boxes meet.
bool boxesMeet(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b);

}  // namespace cloudcontact
