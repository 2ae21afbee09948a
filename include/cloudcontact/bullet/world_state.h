// The state of a running world in memory: to go back to it, as often as you like, or to go on from
// it in another world of the same bodies.
//
// A world that goes back to a state goes on as it did from there, to the bit: with the rigid bodies
// it keeps the contacts with their impulses, what pairs of clouds remember of their last step, and
// the order of Bullet's pairs and manifolds, which is that of the solver's rows.
#pragma once

#include <cloudcontact/bullet/cloud_contact.h>

#include <string>

class btDynamicsWorld;

namespace cloudcontact {

// A value: copy it, send it to another process of the same build.
struct WorldState {
  std::string bytes;
};

// Call it between two steps. Places, velocities, forces and sleep of the rigid bodies, contacts,
// joints' impulses and whether they are enabled, and the time that stepSimulation() has left over.
// Not kept is what you set and a step does not change: shapes, masses, friction, gravity, motors,
// the solver. A world in float keeps 2 KB a body and 1 KB a pair in contact. Throws
// std::invalid_argument for a world with soft or multi-bodies.
WorldState saveState(btDynamicsWorld& world, const CloudContact& contact);

// Puts a world back. Its rigid bodies and joints must be those of the saved world, or made as they
// were in another: as many, in the same order, of the same masses and kinds of shape. Throws
// std::invalid_argument where they are not, and std::runtime_error for bytes that are no state;
// then the world is as it was. With a broad phase other than btDbvtBroadphase the order of pairs
// that meet later may differ, and with it the last bits.
void restoreState(btDynamicsWorld& world, const CloudContact& contact, const WorldState& state);

}  // namespace cloudcontact
