// One backward Euler step of each law; springs in series, and the stiffest that a step can hold.
//
// A Maxwell branch, F' = k v - F k / c, becomes F+ = r (F + k (d+ - d)) with r = c / (c + h k). It
// is unconditionally stable, and what its spring loses its dashpot dissipates. In the standard
// linear solid it stands beside a spring; alone it is the Maxwell law. Where the total force would
// be negative the bodies part instead, and the branch unloads to that limit: its spring gives up
// force without pushing a body, so nothing is gained on the way back in. A dent that outlives the
// touch is not kept: a pair's depth is one number, and the next touch may be elsewhere.
//
// The line over a step is exact for these laws. A table or a user's function gets the steepest of
// its chords to where the depth would go by itself and as far to the other side. Closing along it
// takes at least what is stored, and parting returns at most that, if the step ends within those
// chords or the law only gets steeper.
#include <cloudcontact/law/law.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace cloudcontact {

namespace {

// [m/s^2] This times the step is the smallest rate over which the chords of a nonlinear law are
// taken. A body at rest needs a slope too, and a step of gravity is how far it would go by itself.
constexpr double kLeastPull = 9.81;

// k h^2 / m of the stiffest spring. At damping ratio 1 the backward Euler rows that Bullet solves
// leave 1 / (1 + sqrt(kHardness)) of a penetration after each step; the row is stable at any value.
// A softer spring lets a stack buckle under its own weight; with a harder one ten sweeps no longer
// carry the weight down the stack (docs/tried.md).
constexpr double kHardness = 10.0;

constexpr double kDifference = 1e-6;  // of a depth, for the slope of a user's law

template <class... Parts>
struct Overloaded : Parts... {
  using Parts::operator()...;
};
template <class... Parts>
Overloaded(Parts...) -> Overloaded<Parts...>;

[[noreturn]] void refuse(const char* field, const char* wanted) {
  throw std::invalid_argument(std::string(field) + " must be " + wanted);
}

void notNegative(double value, const char* field) {
  if (!(value >= 0) || !std::isfinite(value)) refuse(field, "0 or more, and finite");
}

void positive(double value, const char* field) {
  if (!(value > 0) || !std::isfinite(value)) refuse(field, "positive and finite");
}

void validateTable(const TableLaw& law) {
  if (law.depthForce.empty()) refuse("TableLaw::depthForce", "given at least one {depth, force}");
  double before = -1;
  for (const auto& [depth, force] : law.depthForce) {
    notNegative(depth, "TableLaw::depthForce, each depth,");
    notNegative(force, "TableLaw::depthForce, each force,");
    if (!(depth > before)) refuse("TableLaw::depthForce", "sorted by depth, each deeper");
    before = depth;
  }
  if (before == 0) refuse("TableLaw::depthForce", "given a depth beyond 0");
  notNegative(law.damping, "TableLaw::damping");
}

// Interpolated between two points of the table, the first of which may be {0, 0}.
double tableForce(const TableLaw& law, double depth) {
  const auto& rows = law.depthForce;
  const auto above =
      std::lower_bound(rows.begin(), rows.end(), depth,
                       [](const std::array<double, 2>& row, double d) { return row[0] < d; });
  std::size_t to = static_cast<std::size_t>(above - rows.begin());
  if (to == 0 && !(depth < rows[0][0])) return rows[0][1];
  to = std::min(to, rows.size() - 1);
  const std::array<double, 2> from = to > 0 ? rows[to - 1] : std::array<double, 2>{0, 0};
  const double slope = (rows[to][1] - from[1]) / (rows[to][0] - from[0]);
  return std::max(0.0, from[1] + slope * (depth - from[0]));
}

// [N/m] From the right at a point of the table.
double tableSlope(const TableLaw& law, double depth) {
  const auto& rows = law.depthForce;
  std::size_t to = 0;
  while (to + 1 < rows.size() && !(depth < rows[to][0])) ++to;
  if (to == 0 && !(rows[0][0] > 0)) return 0;
  const std::array<double, 2> from = to > 0 ? rows[to - 1] : std::array<double, 2>{0, 0};
  return (rows[to][1] - from[1]) / (rows[to][0] - from[0]);
}

double userForce(const UserLaw& law, double depth, double rate) {
  const double force = law.force(depth, rate);
  if (!std::isfinite(force))
    throw std::runtime_error("UserLaw::force gave a value that is not finite at depth " +
                             std::to_string(depth) + " m, rate " + std::to_string(rate) +
                             " m/s; return a finite force [N]");
  return std::max(0.0, force);
}

// The fraction of its force that a Maxwell branch keeps over a step.
double kept(double stiffness, double damping, double step) {
  return damping > 0 ? damping / (damping + step * stiffness) : 0;
}

// The branch's force after the step, at least what makes the sum with `beside` [N] zero.
double branchAfter(double stiffness, double damping, double beside, const LawState& before,
                   double depth, double step) {
  const double free =
      kept(stiffness, damping, step) * (before.branchForce + stiffness * (depth - before.depth));
  return std::max(free, -beside);
}

// The line of a nonlinear law f(depth, rate) from its state.
template <class Force>
LawTangent chords(const Force& f, const LawState& before, double closing, double step) {
  const double rest = before.depth > 0 ? f(before.depth, 0.0) : 0.0;
  const double rate = std::max(std::abs(closing), kLeastPull * step);
  double grip = (f(before.depth + step * rate, rate) - rest) / rate;
  const double back = std::min(rate, before.depth / step);
  if (back > 0) {
    const double depth = before.depth - step * back;
    const double there = depth > 0 ? f(depth, -back) : 0.0;
    grip = std::max(grip, (rest - there) / back);
  }
  return {rest, std::max(0.0, grip)};
}

void validate(const Law& law, const LawState& before, double depth, double step) {
  if (std::holds_alternative<Rigid>(law)) throw std::invalid_argument("Rigid: has no force");
  if (!(step > 0) || !std::isfinite(step))
    throw std::invalid_argument("viscoelastic law: the step must be positive and finite");
  if (!std::isfinite(depth) || !std::isfinite(before.depth) || !std::isfinite(before.branchForce))
    throw std::invalid_argument("viscoelastic law: depth and state must be finite");
}

}  // namespace

void validate(const Law& law) {
  const auto spring = [](const auto& l, const char* stiffness, const char* damping) {
    notNegative(l.stiffness, stiffness);
    notNegative(l.damping, damping);
    if (l.stiffness + l.damping == 0) refuse(stiffness, "positive where there is no damping");
  };
  std::visit(Overloaded{[&](const KelvinVoigt& l) {
                          spring(l, "KelvinVoigt::stiffness", "KelvinVoigt::damping");
                        },
                        [&](const Foundation& l) {
                          spring(l, "Foundation::stiffness", "Foundation::damping");
                        },
                        [](const Rigid&) {},
                        [](const Maxwell& l) {
                          positive(l.stiffness, "Maxwell::stiffness");
                          positive(l.damping, "Maxwell::damping");
                        },
                        [](const StandardLinearSolid& l) {
                          positive(l.stiffness, "StandardLinearSolid::stiffness");
                          notNegative(l.branchStiffness, "StandardLinearSolid::branchStiffness");
                          notNegative(l.branchDamping, "StandardLinearSolid::branchDamping");
                        },
                        [](const UserLaw& l) {
                          if (!l.force) refuse("UserLaw::force", "a function");
                        },
                        [](const TableLaw& l) { validateTable(l); }},
             law);
}

double lawForce(const Law& law, const LawState& before, double depth, double step) {
  validate(law, before, depth, step);
  if (depth <= 0) return 0;
  const double rate = (depth - before.depth) / step;
  return std::visit(Overloaded{[&](const auto& l) {  // KelvinVoigt, Foundation
                                 return std::max(0.0, l.stiffness * depth + l.damping * rate);
                               },
                               [](const Rigid&) { return 0.0; },
                               [&](const Maxwell& l) {
                                 return branchAfter(l.stiffness, l.damping, 0, before, depth, step);
                               },
                               [&](const StandardLinearSolid& l) {
                                 const double beside = l.stiffness * depth;
                                 return beside + branchAfter(l.branchStiffness, l.branchDamping,
                                                             beside, before, depth, step);
                               },
                               [&](const UserLaw& l) { return userForce(l, depth, rate); },
                               [&](const TableLaw& l) {
                                 return std::max(0.0, tableForce(l, depth) + l.damping * rate);
                               }},
                    law);
}

double lawSlope(const Law& law, const LawState& before, double depth, double step) {
  if (!(lawForce(law, before, depth, step) > 0)) return 0;
  return std::visit(
      Overloaded{
          [&](const auto& l) { return l.stiffness + l.damping / step; },
          [](const Rigid&) { return 0.0; },
          [&](const Maxwell& l) { return kept(l.stiffness, l.damping, step) * l.stiffness; },
          [&](const StandardLinearSolid& l) {
            return l.stiffness + kept(l.branchStiffness, l.branchDamping, step) * l.branchStiffness;
          },
          [&](const UserLaw& l) {
            const double more = kDifference * depth, rate = (depth - before.depth) / step;
            return (userForce(l, depth + more, rate + more / step) - userForce(l, depth, rate)) /
                   more;
          },
          [&](const TableLaw& l) { return tableSlope(l, depth) + l.damping / step; }},
      law);
}

LawState lawAdvance(const Law& law, const LawState& before, double depth, double step) {
  validate(law, before, depth, step);
  if (depth <= 0) return {};
  LawState after{depth, 0};
  if (const auto* maxwell = std::get_if<Maxwell>(&law))
    after.branchForce = branchAfter(maxwell->stiffness, maxwell->damping, 0, before, depth, step);
  else if (const auto* solid = std::get_if<StandardLinearSolid>(&law))
    after.branchForce = branchAfter(solid->branchStiffness, solid->branchDamping,
                                    solid->stiffness * depth, before, depth, step);
  return after;
}

LawTangent lawTangent(const Law& law, const LawState& before, double closing, double step) {
  validate(law, before, closing, step);
  const double depth = before.depth;
  return std::visit(
      Overloaded{[&](const auto& l) {  // KelvinVoigt, Foundation
                   return LawTangent{l.stiffness * depth, step * l.stiffness + l.damping};
                 },
                 [](const Rigid&) { return LawTangent{}; },
                 [&](const Maxwell& l) {
                   const double keep = kept(l.stiffness, l.damping, step);
                   return LawTangent{keep * before.branchForce, keep * step * l.stiffness};
                 },
                 [&](const StandardLinearSolid& l) {
                   const double keep = kept(l.branchStiffness, l.branchDamping, step);
                   const double force = l.stiffness * depth + keep * before.branchForce;
                   return LawTangent{std::max(0.0, force),
                                     step * (l.stiffness + keep * l.branchStiffness)};
                 },
                 [&](const UserLaw& l) {
                   const auto f = [&l](double d, double rate) { return userForce(l, d, rate); };
                   return chords(f, before, closing, step);
                 },
                 [&](const TableLaw& l) {
                   const auto f = [&l](double d, double rate) {
                     return std::max(0.0, tableForce(l, d) + l.damping * rate);
                   };
                   return chords(f, before, closing, step);
                 }},
      law);
}

KelvinVoigt sharedSpring(const Law& law) {
  if (const auto* spring = std::get_if<KelvinVoigt>(&law)) return *spring;
  if (const auto* area = std::get_if<Foundation>(&law)) return {area->stiffness, area->damping};
  return {std::holds_alternative<Rigid>(law) ? 0.0 : 1.0, 0};
}

std::optional<KelvinVoigt> inSeries(const std::optional<KelvinVoigt>& a,
                                    const std::optional<KelvinVoigt>& b) {
  if (!a || !b) return a ? a : b;
  const double sum = a->stiffness + b->stiffness;
  if (!(sum > 0)) return KelvinVoigt{0, 0};  // two bodies that do not resist at all
  const double ka = a->stiffness / sum, kb = b->stiffness / sum;
  return KelvinVoigt{a->stiffness * kb, a->damping * kb * kb + b->damping * ka * ka};
}

KelvinVoigt stepLimited(double mass, double step) {
  if (!(mass > 0) || !(step > 0) || !std::isfinite(mass) || !std::isfinite(step))
    throw std::invalid_argument("stepLimited: mass and step must be positive and finite");
  const double stiffness = kHardness * mass / (step * step);
  return {stiffness, 2 * std::sqrt(stiffness * mass)};
}

}  // namespace cloudcontact
