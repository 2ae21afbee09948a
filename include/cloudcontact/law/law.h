// Law: how a pair's force follows from its penetration depth. The paper's Kelvin-Voigt law, and
// what its step 3 names beside it: "a viscoelastic model other than the Kelvin-Voigt model", "a
// function", "a lookup table". Depths are positive inside, rates positive where bodies close.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <variant>
#include <vector>

namespace cloudcontact {

// F = k d + c v, paper (3): one spring a pair, shared out among its contacts.
struct KelvinVoigt {
  double stiffness = 0;  // k [N/m]
  double damping = 0;    // c [N s/m]
};

// The same law per area; exactly conservative without damping (docs/engine.md, "One spring a
// pair").
struct Foundation {
  double stiffness = 0;  // k [N/m^3]
  double damping = 0;    // c [N s/m^3]
};

// No law: bodies do not give at all, a solver keeps them apart. It has no force of its own.
struct Rigid {};

// A spring and a dashpot in series, F' = k v - F k / c. A sudden blow meets the spring alone; under
// a constant load the body sinks without end.
struct Maxwell {
  double stiffness = 0;  // k [N/m]
  double damping = 0;    // c [N s/m]
};

// A spring beside a Maxwell branch, the simplest model of soft tissue: stiffness k + k1 at first, k
// in the end. A held depth relaxes with time constant c1 / k1, a held force creeps with
// c1 / k1 (k + k1) / k.
struct StandardLinearSolid {
  double stiffness = 0;        // k [N/m]
  double branchStiffness = 0;  // k1 [N/m]
  double branchDamping = 0;    // c1 [N s/m]
};

// Any function of depth [m] (always positive) and rate [m/s] that returns a force [N]; negative
// forces count as 0. Called several times per pair and step, from any thread.
struct UserLaw {
  std::function<double(double depth, double rate)> force;
};

// Linear interpolation between measured points {depth [m], force [N]} of ascending depth, from
// {0, 0} unless the table begins there, and along the last segment beyond the last point. Plus c v.
struct TableLaw {
  std::vector<std::array<double, 2>> depthForce;
  double damping = 0;  // c [N s/m]
};

// How a pair's force follows from its depth: one of the above.
using Law =
    std::variant<KelvinVoigt, Foundation, Rigid, Maxwell, StandardLinearSolid, UserLaw, TableLaw>;

// A law's memory between steps; the default is the state before bodies touch.
struct LawState {
  double depth = 0;        // [m] 0 while they do not touch
  double branchForce = 0;  // [N] in the Maxwell branch
};

// The law over one step as a straight line, which an implicit solver needs: F = force + grip * rate
// at the step's end, where rate is (depth at the end - LawState::depth) / step. The line can be
// negative; use max(0, F).
struct LawTangent {
  double force = 0;  // [N] if the depth stays
  double grip = 0;   // [N s/m] not negative; step k + c for Kelvin-Voigt
};

// Throws std::invalid_argument, naming the field, for a value that is negative or not finite, a law
// without resistance, an empty or unsorted table, or an empty UserLaw. The functions below need a
// valid law.
void validate(const Law& law);

// Backward Euler: the force [N] at the end of a step of `step` seconds that ends at `depth` [m]. 0
// at depth 0 and below, never negative; per area [N/m^2] for Foundation. This and the next three
// functions throw std::invalid_argument for Rigid, a step that is not positive or a depth that is
// not finite, and std::runtime_error where a UserLaw returns a value that is not finite.
double lawForce(const Law& law, const LawState& before, double depth, double step);

// How that force grows with the depth at the step's end [N/m], from the right at a kink; 0 where
// the force is 0. Exact, but a difference for UserLaw, which is called twice.
double lawSlope(const Law& law, const LawState& before, double depth, double step);

// The law's state at the end of that step.
LawState lawAdvance(const Law& law, const LawState& before, double depth, double step);

// The line for a step that begins with the depth changing at `closing` [m/s]. Exact for linear
// laws; for others it returns no more energy than was stored (law.cpp).
LawTangent lawTangent(const Law& law, const LawState& before, double closing, double step);

// What a contact query shares out among its points: k and c of KelvinVoigt and Foundation, none for
// Rigid, and {1, 0} for the others, so that a point's stiffness is its share of the pair's law.
KelvinVoigt sharedSpring(const Law& law);

// Two springs in series: k = kA kB / (kA + kB), c = (cA kB^2 + cB kA^2) / (kA + kB)^2. An empty
// value is a rigid body. Empty if both are; the pair's spring is then automatic
// (automatic_spring.h).
std::optional<KelvinVoigt> inSeries(const std::optional<KelvinVoigt>& a,
                                    const std::optional<KelvinVoigt>& b);

// The stiffest spring that a step of `step` seconds allows for a pair of effective mass `mass`
// [kg], at damping ratio 1. It bounds the automatic spring (docs/engine.md, "One spring a pair").
// Throws std::invalid_argument if mass or step is not positive and finite.
KelvinVoigt stepLimited(double mass, double step);

}  // namespace cloudcontact
