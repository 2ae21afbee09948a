// Bullet's solver settings that a contact law needs: finds wrong ones, and sets them right.
#pragma once

#include <string>
#include <vector>

class btDynamicsWorld;

namespace cloudcontact {

// The settings of a world that defeat the Kelvin-Voigt law (split impulse, an MLCP solver, no warm
// starting, one friction direction, ...), one sentence each, which says what to set. Empty if all
// are right.
std::vector<std::string> diagnose(const btDynamicsWorld& world);

// Sets everything that diagnose() checks, except the type of the solver.
void recommendedSettings(btDynamicsWorld& world);

}  // namespace cloudcontact
