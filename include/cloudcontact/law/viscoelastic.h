// Laws between depth and force beside Kelvin-Voigt's: "a viscoelastic model other than the
// Kelvin-Voigt model", "a function", "a lookup table" (paper, step 3), as values, and how one is
// stepped. Depths and rates are positive where bodies close.
#pragma once

#include <array>
#include <functional>
#include <variant>
#include <vector>

namespace cloudcontact {

// F = k d + c v: paper (3).
struct KelvinVoigtLaw {
  double stiffness = 0;  // k [N/m]
  double damping = 0;    // c [N s/m]
};

// A spring and a dashpot in series, F' = k v - F k / c: a hard blow meets the spring alone, and
// what presses on sinks on, without end.
struct MaxwellLaw {
  double stiffness = 0;  // k [N/m]
  double damping = 0;    // c [N s/m]
};

// A spring beside a Maxwell branch: k + k1 at once, k alone in the end; in between a held depth
// relaxes with time c1 / k1, a held force creeps with time c1 / k1 (k + k1) / k. Soft tissue's
// simplest model.
struct StandardLinearSolidLaw {
  double stiffness = 0;        // k [N/m]
  double branchStiffness = 0;  // k1 [N/m]
  double branchDamping = 0;    // c1 [N s/m]
};

// Any function of depth [m] (always positive) and its rate [m/s] to a force [N]; what it says below
// 0 counts as 0. Called several times a pair and step, from whichever thread steps the pair.
struct UserLaw {
  std::function<double(double depth, double rate)> force;
};

// Straight lines between measured points {depth [m], force [N]} of ascending depth, from {0, 0}
// unless the table begins there; beyond the last point the last line goes on. Plus c v.
struct TableLaw {
  std::vector<std::array<double, 2>> depthForce;
  double damping = 0;  // c [N s/m]
};

using ViscoelasticLaw =
    std::variant<KelvinVoigtLaw, MaxwellLaw, StandardLinearSolidLaw, UserLaw, TableLaw>;

// What a law remembers between steps; as it is here, before bodies touch.
struct LawState {
  double depth = 0;        // [m] 0 while they do not touch
  double branchForce = 0;  // [N] in the Maxwell branch: its spring's
};

// The law over one step as a straight line: F = force + grip * rate at the step's end, rate the
// depth's over the step, (depth at its end - LawState::depth) / step. What an implicit solver
// needs. Not below 0 either: who uses it takes max(0, F).
struct LawTangent {
  double force = 0;  // [N] should the depth stay
  double grip = 0;   // [N s/m] not negative; of Kelvin-Voigt step k + c
};

// Throws std::invalid_argument, naming the field, where a value is negative, not finite, or leaves
// nothing that resists; where a table is empty or its depths do not ascend; where a UserLaw holds
// no function. The functions below take a law that has passed.
void validate(const ViscoelasticLaw& law);

// Backward Euler: the force [N] at the end of a step of `step` seconds, should the depth [m] then
// be `depth`. Never pulls; 0 at no depth. Here and below: throws std::invalid_argument where `step`
// is not positive or a depth not finite, std::runtime_error where a UserLaw's value is not finite.
double lawForce(const ViscoelasticLaw& law, const LawState& before, double depth, double step);

// What the law remembers at the end of that step.
LawState lawAdvance(const ViscoelasticLaw& law, const LawState& before, double depth, double step);

// The line for a step that begins with the depth changing at `closing` [m/s]. Exact, whatever
// `closing`, where the law is linear; else it gives back no more than was stored
// (viscoelastic.cpp).
LawTangent lawTangent(const ViscoelasticLaw& law, const LawState& before, double closing,
                      double step);

}  // namespace cloudcontact
