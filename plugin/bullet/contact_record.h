// The contacts of a world as bytes in Bullet's files, so that a world goes on as if it had not been
// saved: pairs and manifolds in their order, the points with their impulses, and what pairs with
// clouds know of their last step. Objects are named by their rank among the world's rigid bodies;
// contacts of others are left out.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

class btDynamicsWorld;
class btRigidBody;

namespace cloudcontact {

class NarrowPhase;

std::string contactsOf(btDynamicsWorld& world, const NarrowPhase& clouds);

// Throws std::runtime_error for bytes that are no contacts of so many bodies.
void checkContacts(std::span<const char> bytes, std::size_t bodies);

// `bodies`: those of the record, by rank, all in the world. It finds the contacts where they are,
// unless all pairs of the record are there, and sets them to what they were. `restorePhase`: sets
// the broad phase to what it was, but for its pairs; without, pairs that the record does not have
// stay. Throws as checkContacts().
void restoreContacts(btDynamicsWorld& world, const NarrowPhase& clouds,
                     const std::vector<btRigidBody*>& bodies, std::span<const char> bytes,
                     const std::function<void()>& restorePhase = {});

}  // namespace cloudcontact
