// Fidelity: the error that a user can bear, for which the library does no more than it needs.
#pragma once

namespace cloudcontact {

struct Fidelity {
  // [m] The surface that contacts see may differ from the cloud's by this much. 0: not at all, so
  // every contact is the cloud's.
  double tolerance = 0;
};

}  // namespace cloudcontact
