// Bullet's solver settings that a contact law needs: finds wrong ones, and sets them right. Finds
// shapes that clouds cannot touch, and bodies whose mass is not that of their clouds.
#pragma once

#include <string>
#include <vector>

class btDynamicsWorld;

namespace cloudcontact {

// One sentence each, which names the object and says what to do; empty if all is right:
// - settings of the world that defeat the Kelvin-Voigt law (split impulse, an MLCP solver, no warm
//   starting, one friction direction, too few sweeps, ...);
// - objects that clouds do not touch, because of their shape, material or law, or because another
//   algorithm takes the pair; and two laws that do not go together;
// - bodies of clouds that turn wrongly: the center of mass is not their origin, or their inertia is
//   not that of their matter.
// docs/bullet.md, "What it reports", has the bounds.
std::vector<std::string> diagnose(const btDynamicsWorld& world);

// Sets all settings that diagnose() checks, except the type of the solver. They hold for all pairs
// of the world, also those of Bullet's own shapes; with NewtonSolver::cloudsOnly nothing
// needs to be set, and nothing is.
void recommendedSettings(btDynamicsWorld& world);

}  // namespace cloudcontact
