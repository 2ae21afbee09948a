// One backward Euler step of each law.
//
// A Maxwell branch, F' = k v - F k / c, is F+ = r (F + k (d+ - d)) with r = c / (c + h k): never
// unstable, and what its spring loses is what its dashpot takes. In the standard linear solid it
// stands beside a spring; alone it is the Maxwell law. Where the whole would pull, bodies part
// instead, and the branch goes slack as far as that: its spring gives up what it held without
// pushing anybody, so that nothing is gained on the way back in. A surface that comes back slower
// than what dented it, and is found dented by the next touch, is not kept: a pair's depth is one
// number, the next touch may be elsewhere.
//
// The line over a step is exact for these. What is bent, a table or a user's function, gets the
// steepest of its chords to where the depth would go by itself and as far to the other side.
// Closing along it takes at least what is stored, parting gives back at most that, provided that
// the step ends within those chords or the law only steepens.
#include <cloudcontact/law/viscoelastic.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace cloudcontact {

namespace {

// [m/s^2] Times the step: the least rate over which a bent law's chords are taken. What rests must
// know how its law resists, too, and a step of gravity is what it would go by itself.
constexpr double kLeastPull = 9.81;

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

// The table's line through two of its points, the first of which may be {0, 0} itself.
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

double userForce(const UserLaw& law, double depth, double rate) {
  const double force = law.force(depth, rate);
  if (!std::isfinite(force))
    throw std::runtime_error("UserLaw::force gave a value that is not finite at depth " +
                             std::to_string(depth) + " m, rate " + std::to_string(rate) +
                             " m/s; return a finite force [N]");
  return std::max(0.0, force);
}

// The share of its force that a Maxwell branch keeps over a step.
double kept(double stiffness, double damping, double step) {
  return damping > 0 ? damping / (damping + step * stiffness) : 0;
}

// What a branch holds after the step, no slacker than lets the whole, with `beside` [N], be 0.
double branchAfter(double stiffness, double damping, double beside, const LawState& before,
                   double depth, double step) {
  const double free =
      kept(stiffness, damping, step) * (before.branchForce + stiffness * (depth - before.depth));
  return std::max(free, -beside);
}

// The line of a bent law f(depth, rate) from where the state stands.
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

void check(const LawState& before, double depth, double step) {
  if (!(step > 0) || !std::isfinite(step))
    throw std::invalid_argument("viscoelastic law: the step must be positive and finite");
  if (!std::isfinite(depth) || !std::isfinite(before.depth) || !std::isfinite(before.branchForce))
    throw std::invalid_argument("viscoelastic law: depth and state must be finite");
}

}  // namespace

void validate(const ViscoelasticLaw& law) {
  std::visit(Overloaded{[](const KelvinVoigtLaw& l) {
                          notNegative(l.stiffness, "KelvinVoigtLaw::stiffness");
                          notNegative(l.damping, "KelvinVoigtLaw::damping");
                          if (l.stiffness + l.damping == 0)
                            refuse("KelvinVoigtLaw::stiffness",
                                   "positive where there is no damping");
                        },
                        [](const MaxwellLaw& l) {
                          positive(l.stiffness, "MaxwellLaw::stiffness");
                          positive(l.damping, "MaxwellLaw::damping");
                        },
                        [](const StandardLinearSolidLaw& l) {
                          positive(l.stiffness, "StandardLinearSolidLaw::stiffness");
                          notNegative(l.branchStiffness, "StandardLinearSolidLaw::branchStiffness");
                          notNegative(l.branchDamping, "StandardLinearSolidLaw::branchDamping");
                        },
                        [](const UserLaw& l) {
                          if (!l.force) refuse("UserLaw::force", "a function");
                        },
                        [](const TableLaw& l) { validateTable(l); }},
             law);
}

double lawForce(const ViscoelasticLaw& law, const LawState& before, double depth, double step) {
  check(before, depth, step);
  if (depth <= 0) return 0;
  const double rate = (depth - before.depth) / step;
  return std::visit(Overloaded{[&](const KelvinVoigtLaw& l) {
                                 return std::max(0.0, l.stiffness * depth + l.damping * rate);
                               },
                               [&](const MaxwellLaw& l) {
                                 return branchAfter(l.stiffness, l.damping, 0, before, depth, step);
                               },
                               [&](const StandardLinearSolidLaw& l) {
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

LawState lawAdvance(const ViscoelasticLaw& law, const LawState& before, double depth, double step) {
  check(before, depth, step);
  if (depth <= 0) return {};
  LawState after{depth, 0};
  if (const auto* maxwell = std::get_if<MaxwellLaw>(&law))
    after.branchForce = branchAfter(maxwell->stiffness, maxwell->damping, 0, before, depth, step);
  else if (const auto* solid = std::get_if<StandardLinearSolidLaw>(&law))
    after.branchForce = branchAfter(solid->branchStiffness, solid->branchDamping,
                                    solid->stiffness * depth, before, depth, step);
  return after;
}

LawTangent lawTangent(const ViscoelasticLaw& law, const LawState& before, double closing,
                      double step) {
  check(before, closing, step);
  const double depth = before.depth;
  return std::visit(
      Overloaded{[&](const KelvinVoigtLaw& l) {
                   return LawTangent{l.stiffness * depth, step * l.stiffness + l.damping};
                 },
                 [&](const MaxwellLaw& l) {
                   const double keep = kept(l.stiffness, l.damping, step);
                   return LawTangent{keep * before.branchForce, keep * step * l.stiffness};
                 },
                 [&](const StandardLinearSolidLaw& l) {
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

}  // namespace cloudcontact
