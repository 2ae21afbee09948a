// Whether Bullet's center of mass and inertia of a body are those of its clouds.
#pragma once

#include <vector>

class btCollisionObject;

namespace cloudcontact {

// What is wrong, one sentence each; empty for a body that contacts do not move, or that has shapes
// other than clouds, whose density is not known.
//
// A user may know better where the matter is than a cloud: a body with ballast has another center
// and inertia than its voxels make. So a center inside the body's bounds and an inertia that some
// matter in them could have count as stated, unless the inertia is one that follows from the shape,
// which shows that nobody stated it.
std::vector<const char*> wrongMatter(const btCollisionObject& object);

}  // namespace cloudcontact
