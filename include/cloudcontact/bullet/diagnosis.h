// Bullet's solver settings that a contact law needs: finds wrong ones, and sets them right. Finds
// shapes that clouds cannot touch.
#pragma once

#include <string>
#include <vector>

class btDynamicsWorld;

namespace cloudcontact {

// The settings of a world that defeat the Kelvin-Voigt law (split impulse, an MLCP solver, no warm
// starting, one friction direction, ...), and the objects that its clouds do not touch, because of
// their shape or because another algorithm takes the pair. One sentence each, which says what to
// do. Empty if all is right.
std::vector<std::string> diagnose(const btDynamicsWorld& world);

// Sets all settings that diagnose() checks, except the type of the solver.
void recommendedSettings(btDynamicsWorld& world);

}  // namespace cloudcontact
