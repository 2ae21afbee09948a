// `simulate --explain`: what was modelled of each pair of clouds, what was left out, and the cost.
#pragma once

#include "io/json.h"
#include "scene/world.h"

namespace cloudcontact::program {

// An array, the costliest pair first: "a", "b", "used", "skipped", "microseconds" (a query),
// "queries", "share" (of all the time), "expectedError" [m].
Json explanation(const World& world);

// The same as a table.
void printExplanation(const Json& explanation);

}  // namespace cloudcontact::program
