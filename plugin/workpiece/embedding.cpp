// All searches find the root of g(d) = index(d) - stiffness (reach - d), which rises with d: below
// the root the hand is stronger, above it the material. They keep a bracket, so no step leaves the
// range. Search::Newton takes the slope from the bracket (Illinois secant), so a kink in the law
// costs a step, not the solution.
#include <cloudcontact/workpiece/embedding.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace cloudcontact {

namespace {

struct Bracket {
  double low, high;     // depths [m]
  double below, above;  // g there [N]
  double width() const { return high - low; }
  double middle() const { return 0.5 * (low + high); }
};

// g, and how often it was evaluated.
struct Balance {
  const Index& index;
  const HandSpring& hand;
  int evaluations = 0;
  double force = 0;  // the index at the last depth
  double operator()(double depth) {
    ++evaluations;
    force = index(depth);
    return force - hand.stiffness * (hand.reach - depth);
  }
};

void validate(const HandSpring& hand, const EmbeddingSettings& settings) {
  if (!(hand.stiffness >= 0) || !std::isfinite(hand.stiffness) || !std::isfinite(hand.reach))
    throw std::invalid_argument(
        "embed: the hand's stiffness must be zero or more and finite, its "
        "reach finite");
  if (!(settings.tolerance > 0) || settings.tolerance >= 1)
    throw std::invalid_argument("embed: the tolerance must lie between 0 and 1");
  if (settings.iterations < 3) throw std::invalid_argument("embed: give at least 3 iterations");
}

// The next depth to evaluate. A secant too near an end is moved inward, so that the bracket closes
// from both sides.
double next(const Bracket& b, double tolerance) {
  const double secant = b.low - b.below * b.width() / (b.above - b.below);
  const double margin = std::min(0.4 * tolerance, 0.25 * b.width());
  return std::clamp(secant, b.low + margin, b.high - margin);
}

Embedding search(Balance& g, Bracket b, const EmbeddingSettings& settings, double tolerance) {
  Embedding found{b.middle(), 0, g.evaluations, EmbeddingEnd::NotConverged};
  int side = 0;  // the end that moved; if it moves twice, the other's value is halved (Illinois)
  // If three secants do not halve the bracket, a bisection does: no index takes over four times the
  // steps of a bisection.
  double width = b.width();
  int secants = 0;
  while (b.width() > tolerance) {
    if (g.evaluations >= settings.iterations) {
      found.depth = b.middle(), found.iterations = g.evaluations;
      return found;
    }
    const bool halve = settings.search == Search::Bisection || secants == 3;
    const double depth = halve ? b.middle() : next(b, tolerance), value = g(depth);
    secants = halve ? 0 : secants + 1;
    if (!std::isfinite(value)) return {b.low, g.force, g.evaluations, EmbeddingEnd::NoNumber};
    if (value == 0) return {depth, g.force, g.evaluations, EmbeddingEnd::Found};
    if (value < 0) {
      b.low = depth, b.below = value;
      if (side < 0) b.above *= 0.5;
      side = -1;
    } else {
      b.high = depth, b.above = value;
      if (side > 0) b.below *= 0.5;
      side = 1;
    }
    if (b.width() <= 0.5 * width) width = b.width(), secants = 0;
  }
  return {b.middle(), g.force, g.evaluations, EmbeddingEnd::Found};
}

Embedding embedWithin(Balance& g, double low, double high, const EmbeddingSettings& settings) {
  const double tolerance = settings.tolerance * g.hand.reach;
  const double below = g(low);
  if (!std::isfinite(below)) return {0, 0, g.evaluations, EmbeddingEnd::NoNumber};
  if (below >= 0) return {low, g.force, g.evaluations, EmbeddingEnd::NotPressed};
  const double above = g(high);
  if (!std::isfinite(above)) return {low, 0, g.evaluations, EmbeddingEnd::NoNumber};
  // At the hand's reach g is the index, which is zero or less only if nothing resists.
  if (above <= 0) return {high, g.force, g.evaluations, EmbeddingEnd::TooSoft};
  return search(g, {low, high, below, above}, settings, tolerance);
}

}  // namespace

Embedding embed(const Index& index, const HandSpring& hand, const EmbeddingSettings& settings) {
  validate(hand, settings);
  if (!(hand.stiffness * hand.reach > 0)) return {};
  if (settings.search == Search::Table)
    return EmbeddingTable(index, hand.reach, settings.tableEntries).find(hand, settings, index);
  Balance g{index, hand};
  return embedWithin(g, 0, hand.reach, settings);
}

Embedding embed(const Law& law, const LawState& before, double step, const HandSpring& hand,
                const EmbeddingSettings& settings) {
  // One reference to capture, so that std::function does not allocate.
  const struct Query {
    const Law& law;
    const LawState& before;
    double step;
  } query{law, before, step};
  return embed([&query](double d) { return lawForce(query.law, query.before, d, query.step); },
               hand, settings);
}

EmbeddingTable::EmbeddingTable(const Index& index, double most, int entries) : most_(most) {
  if (!(most > 0) || !std::isfinite(most))
    throw std::invalid_argument("EmbeddingTable: the greatest depth must be positive and finite");
  if (entries < 2) throw std::invalid_argument("EmbeddingTable: give at least 2 entries");
  for (int k = 0; k < entries; ++k) force_.push_back(index(most * k / (entries - 1)));
}

double EmbeddingTable::at(double depth) const {
  const double place = std::max(depth, 0.0) / most_ * static_cast<double>(force_.size() - 1);
  const std::size_t low = std::min(static_cast<std::size_t>(place), force_.size() - 2);
  const double part = place - static_cast<double>(low);
  return force_[low] + part * (force_[low + 1] - force_[low]);
}

Embedding EmbeddingTable::find(const HandSpring& hand, const EmbeddingSettings& settings,
                               const Index& polish) const {
  validate(hand, settings);
  if (!(hand.stiffness * hand.reach > 0)) return {};
  const Index tabulated = [this](double d) { return at(d); };
  // The last entry where the hand is stronger.
  const double apart = most_ / static_cast<double>(force_.size() - 1);
  std::size_t low = 0, high = force_.size() - 1;
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    const double depth = apart * static_cast<double>(middle);
    (force_[middle] < hand.stiffness * (hand.reach - depth) ? low : high) = middle;
  }
  const double from = apart * static_cast<double>(low);
  const double to = std::min(hand.reach, apart * static_cast<double>(high));
  Balance g{polish ? polish : tabulated, hand};
  EmbeddingSettings secants = settings;
  secants.search = Search::Newton;
  Embedding found = from < to ? embedWithin(g, from, to, secants) : Embedding{};
  const bool outside = (found.end == EmbeddingEnd::NotPressed && from > 0) ||
                       (found.end == EmbeddingEnd::TooSoft && to < hand.reach);
  if (from < to && !outside) return found;
  // `polish` is not the tabulated index: search the whole range.
  return embedWithin(g, 0, hand.reach, secants);
}

}  // namespace cloudcontact
