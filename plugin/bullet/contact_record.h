// The contacts of a world as bytes in Bullet's files, so that a world goes on as if it had not been
// saved: pairs and manifolds in their order, the points with their impulses, and what pairs with
// clouds know of their last step. Objects are named by their rank among the world's rigid bodies;
// contacts of others are left out.
#pragma once

#include <span>
#include <string>
#include <vector>

class btDynamicsWorld;
class btRigidBody;

namespace cloudcontact {

class NarrowPhase;

std::string contactsOf(btDynamicsWorld& world, const NarrowPhase& clouds);

// `bodies`: those of the file, by rank, all in the world. It finds the contacts where they are, and
// sets them to what they were. Throws std::runtime_error for bytes that are none.
void restoreContacts(btDynamicsWorld& world, const NarrowPhase& clouds,
                     const std::vector<btRigidBody*>& bodies, std::span<const char> bytes);

}  // namespace cloudcontact
