// The settings of Bullet's solver that a contact law needs. What the bounds follow from is in
// docs/bullet.md, "What it reports".
#pragma once

#include <BulletDynamics/ConstraintSolver/btContactSolverInfo.h>

namespace cloudcontact {

constexpr int kFewestSweeps = 4, kSweeps = 10;
constexpr btScalar kMostResidual = btScalar(1e-4), kMostRelaxation = btScalar(1.7);
constexpr btScalar kBounceThreshold = btScalar(0.2);

// Sets those that are wrong.
void recommend(btContactSolverInfo& info);

}  // namespace cloudcontact
