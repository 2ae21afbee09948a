// All searches find the root of g(d) = index(d) - stiffness (reach - d), which rises with d: below
// the root the hand is stronger, above it the material. They keep a bracket, so no step leaves the
// range. Search::Newton starts from the end of the bracket with the smaller value. Where the slope
// there leads out of the bracket, as at a kink, it takes the secant between the ends.
#include <cloudcontact/workpiece/embedding.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace cloudcontact {

namespace {

constexpr int kMostTangents = 12;  // that need not halve the bracket

struct Bracket {
  double low, high;     // depths [m]
  double below, above;  // g there [N]
  double width() const { return high - low; }
  double middle() const { return 0.5 * (low + high); }
};

// g, and how often the index was evaluated.
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

double secant(const Bracket& b) {
  return b.low - b.below * b.width() / (b.above - b.below);
}

// Newton's next depth from the better end, and a little beyond the root that it expects, so that
// the bracket closes from both sides.
double tangent(const Balance& g, const Bracket& b, bool fromLow, double margin) {
  const double start = fromLow ? b.low : b.high, value = fromLow ? b.below : b.above;
  const double slope = g.index.slope(start) + g.hand.stiffness;
  const double newton = start - value / slope + (fromLow ? margin : -margin);
  return newton > b.low && newton < b.high ? newton : secant(b);  // NaN too
}

// Tangents, as long as they close in: three that halve neither the bracket nor g show a kink or a
// jump.
// Then a bisection and secants follow, in which the value of an end that stays is halved
// (Illinois), and again a bisection after three: no index takes over four times the steps of a
// bisection.
Embedding search(Balance& g, Bracket b, const EmbeddingSettings& settings, double tolerance) {
  double width = b.width();
  int steps = 0,
      side = -b.below < b.above ? -1 : 1;  // side: the end that moved last, at first the better
  bool tangents = static_cast<bool>(g.index.slope);
  int inARow = 0;
  while (b.width() > tolerance) {
    if (g.evaluations >= settings.iterations)
      return {b.middle(), g.force, g.evaluations, EmbeddingEnd::NotConverged};
    const bool halve = settings.search == Search::Bisection || steps == 3;
    if (halve) tangents = false;
    const double margin = std::min(0.4 * tolerance, 0.25 * b.width());
    const double wanted = halve      ? b.middle()
                          : tangents ? tangent(g, b, side < 0, margin)
                                     : secant(b);
    const double depth = std::clamp(wanted, b.low + margin, b.high - margin), value = g(depth);
    steps = halve ? 0 : steps + 1;
    if (!std::isfinite(value)) return {b.low, g.force, g.evaluations, EmbeddingEnd::NoNumber};
    if (value == 0) return {depth, g.force, g.evaluations, EmbeddingEnd::Found};
    // A tangent may also close in from one side, where it halves g each time.
    if (tangents && ++inARow < kMostTangents &&
        std::abs(value) <= 0.5 * (side < 0 ? -b.below : b.above))
      steps = 0;
    const int moved = value < 0 ? -1 : 1;
    (value < 0 ? b.low : b.high) = depth;
    (value < 0 ? b.below : b.above) = value;
    if (moved == side && !tangents) (value < 0 ? b.above : b.below) *= 0.5;
    side = moved;
    if (b.width() <= 0.5 * width) width = b.width(), steps = 0;
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
  if (settings.search == Search::Table) {
    Embedding found =
        EmbeddingTable(index, hand.reach, settings.tableEntries).find(hand, settings, index);
    found.iterations += settings.tableEntries;
    return found;
  }
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
  const auto force = [&query](double d) {
    return lawForce(query.law, query.before, d, query.step);
  };
  // A user's law has no slope of its own, and a difference costs as much as a secant.
  if (std::holds_alternative<UserLaw>(law)) return embed(Index(force), hand, settings);
  const auto slope = [&query](double d) {
    return lawSlope(query.law, query.before, d, query.step);
  };
  return embed(Index(force, slope), hand, settings);
}

Embedding embed(const InteractionIndex& index, const Interaction& before, double step,
                const HandSpring& hand, const EmbeddingSettings& settings) {
  if (!index) throw std::invalid_argument("embed: the index must be a function");
  if (!(step > 0) || !std::isfinite(step))
    throw std::invalid_argument("embed: the step must be positive and finite");
  const struct Query {
    const InteractionIndex& index;
    const Interaction& before;
    double step;
  } query{index, before, step};
  const auto force = [&query](double d) {
    Interaction now = query.before;
    now.depth = d;
    now.speed = (d - query.before.depth) / query.step;
    now.acceleration = (now.speed - query.before.speed) / query.step;
    return query.index(now);
  };
  return embed(Index(force), hand, settings);
}

void EmbeddingTable::fill(const Index& index, double most, int entries) {
  if (!(most > 0) || !std::isfinite(most))
    throw std::invalid_argument("EmbeddingTable: the greatest depth must be positive and finite");
  if (entries < 2) throw std::invalid_argument("EmbeddingTable: give at least 2 entries");
  most_ = most;
  force_.clear();
  for (int k = 0; k < entries; ++k) force_.push_back(index(most * k / (entries - 1)));
}

double EmbeddingTable::at(double depth) const {
  const double place = std::max(depth, 0.0) / most_ * static_cast<double>(force_.size() - 1);
  const std::size_t low = std::min(static_cast<std::size_t>(place), force_.size() - 2);
  const double part = place - static_cast<double>(low);
  return force_[low] + part * (force_[low + 1] - force_[low]);
}

// From the last entry where the hand is stronger to the next.
EmbeddingTable::Segment EmbeddingTable::bracket(const HandSpring& hand) const {
  if (force_.empty()) throw std::logic_error("EmbeddingTable: the table is empty; fill it first");
  const double apart = most_ / static_cast<double>(force_.size() - 1);
  std::size_t low = 0, high = force_.size() - 1;
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    const double depth = apart * static_cast<double>(middle);
    (force_[middle] < hand.stiffness * (hand.reach - depth) ? low : high) = middle;
  }
  return {apart * static_cast<double>(low), apart * static_cast<double>(high)};
}

Embedding EmbeddingTable::find(const HandSpring& hand, const EmbeddingSettings& settings) const {
  const Index tabulated([this](double d) { return at(d); });
  Embedding found = find(hand, settings, tabulated);
  found.iterations = 0;
  return found;
}

Embedding EmbeddingTable::find(const HandSpring& hand, const EmbeddingSettings& settings,
                               const Index& polish) const {
  validate(hand, settings);
  const Segment segment = bracket(hand);
  if (!(hand.stiffness * hand.reach > 0)) return {};
  const double from = segment.low, to = std::min(hand.reach, segment.high);
  Balance g{polish, hand};
  EmbeddingSettings newton = settings;
  newton.search = Search::Newton;
  Embedding found = from < to ? embedWithin(g, from, to, newton) : Embedding{};
  const bool outside = (found.end == EmbeddingEnd::NotPressed && from > 0) ||
                       (found.end == EmbeddingEnd::TooSoft && to < hand.reach);
  if (from < to && !outside) return found;
  // `polish` is not the tabulated index: search the whole range.
  return embedWithin(g, 0, hand.reach, newton);
}

}  // namespace cloudcontact
