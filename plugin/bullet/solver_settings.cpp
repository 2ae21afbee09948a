// Sets them.
#include "bullet/solver_settings.h"

namespace cloudcontact {

void recommend(btContactSolverInfo& info) {
  info.m_splitImpulse = 0;
  info.m_solverMode |= SOLVER_USE_WARMSTARTING | SOLVER_USE_2_FRICTION_DIRECTIONS |
                       SOLVER_ENABLE_FRICTION_DIRECTION_CACHING;
  info.m_warmstartingFactor = 1;
  info.m_linearSlop = 0;
  info.m_globalCfm = 0;
  info.m_sor = 1;
  if (info.m_numIterations < kFewestSweeps) info.m_numIterations = kSweeps;
  if (!(info.m_leastSquaresResidualThreshold <= kMostResidual))
    info.m_leastSquaresResidualThreshold = 0;
  if (!(info.m_restitutionVelocityThreshold <= kBounceThreshold))
    info.m_restitutionVelocityThreshold = kBounceThreshold;
}

}  // namespace cloudcontact
