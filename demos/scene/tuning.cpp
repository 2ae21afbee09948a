// The ladder of voxels, and the choice on it.
#include "scene/tuning.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <string>

#include "io/errors.h"
#include "io/text.h"

namespace cloudcontact::program {

namespace {

constexpr double kShare = 0.95;  // of the places
constexpr std::size_t kSamples[] = {300, 150, 75};
constexpr std::size_t kAllSamples = 1'000'000'000;
constexpr double kStep = 1.4142135623730951;  // between the voxels of two trials
constexpr int kMostSteps = 40;
// The error may fall faster than the voxel by these factors: on the first rungs, and from kSettled.
constexpr double kLuckEarly = 10, kLuck = 3;
constexpr int kSettled = 6;
// Bodies that do not touch at half the default voxel (trials.cpp) do not touch.
constexpr int kUnseen = 10;

double quantile(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::infinity();
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::ceil(kShare * double(values.size() - 1)))];
}

std::string memoryText(double bytes) {
  char text[32];
  const char* units[] = {"MB", "GB", "TB"};
  int unit = 0;
  for (bytes /= 1e6; bytes >= 1e3 && unit < 2; bytes /= 1e3) ++unit;
  std::snprintf(text, sizeof text, "%.3g %s", bytes, units[unit]);
  return text;
}

class Ladder {
 public:
  Ladder(double tolerance, const TuneLimits& limits,
         const std::function<Trial(const TuneSetting&)>& attempt)
      : tolerance_(tolerance), limits_(limits), attempt_(attempt) {}

  // The coarsest rung that holds the tolerance, as does the next finer one: a coarse voxel may hold
  // it by chance.
  int firstRung() {
    for (int rung = 0; rung < kMostSteps; ++rung) {
      if (rung > 0) checkNext(rung);
      if (!holds(rung, kSamples[0])) continue;
      if (limits_.fixed) return rung;
      checkNext(rung + 1);
      if (holds(rung + 1, kSamples[0]) && !loses(rung, rung + 1)) return rung;
    }
    refuse(rungs_.rbegin()->second.predicted());
  }

  // Of that rung and the next finer one with fewer samples, the one with the fewest lookups.
  std::pair<int, std::size_t> choose() {
    const int first = firstRung();
    std::pair<int, std::size_t> best{first, kSamples[0]};
    for (int rung = first; rung <= first + (limits_.fixed ? 0 : 1); ++rung)
      for (const std::size_t samples : kSamples)
        if (holds(rung, samples) && trial(rung, samples).lookups < trial(best).lookups)
          best = {rung, samples};
    return best;
  }

  const Trial& trial(int rung, std::size_t samples) {
    const auto known = rungs_.find({rung, samples});
    if (known != rungs_.end()) return known->second;
    const double voxel = limits_.coarsest / std::pow(kStep, rung);
    return rungs_[{rung, samples}] = attempt_({voxel, samples});
  }
  const Trial& trial(const std::pair<int, std::size_t>& at) { return trial(at.first, at.second); }

  bool fits(int rung) const {
    const auto last = std::prev(rungs_.end());
    return expectedBytes(last->second, rung - last->first.first) <= double(limits_.bytes);
  }

 private:
  bool holds(int rung, std::size_t samples) {
    return trial(rung, samples).predicted() <= tolerance_;
  }
  // Whether contacts deeper than the tolerance are not seen.
  bool loses(int coarse, int fine) {
    const Trial &few = trial(coarse, kSamples[0]), &all = trial(fine, kSamples[0]);
    std::size_t lost = 0;
    for (std::size_t k = 0; k < few.depths.size(); ++k)
      lost += few.depths[k] == Trial::kApart && all.depths[k] > tolerance_;
    return double(lost) > (1 - kShare) * double(few.depths.size());
  }
  // Surfaces grow with the square of the resolution.
  static double expectedBytes(const Trial& from, double steps) {
    return double(from.bytes) * std::pow(kStep, 2 * steps);
  }

  // Throws if this rung, or any that may hold the tolerance, does not fit.
  void checkNext(int rung) {
    const Trial& last = trial(rung - 1, kSamples[0]);
    const bool apart = rung > kUnseen && !std::isfinite(last.predicted());
    if (limits_.fixed || apart) refuse(last.predicted());
    const double off = last.predicted() / tolerance_;
    const double steps = std::isfinite(off) ? std::max(1.0, std::log(off) / std::log(kStep)) : 1;
    const double luck = rung < kSettled ? kLuckEarly : kLuck;
    const double least = std::max(1.0, steps - std::log(luck) / std::log(kStep));
    if (expectedBytes(last, least) <= double(limits_.bytes)) return;
    const double shrink = std::sqrt(double(limits_.bytes) / double(last.bytes)) / kStep;
    refuse(last.predicted() / std::max(1.0, shrink), expectedBytes(last, steps));
  }

  [[noreturn]] void refuse(double holds, double needed = 0) const {
    if (!std::isfinite(holds))
      throw BadInput("tune: the bodies do not touch; press them together (--pose, or the scene)");
    const std::string best =
        "; " + lengthText(holds) + " can be held: give --tolerance " + shortNumber(1.1 * holds);
    if (limits_.fixed)
      throw BadInput("--tolerance: the voxels of a saved cloud are too coarse for " +
                     lengthText(tolerance_) + best + ", or digitize the body again");
    if (!(needed > 0))
      throw BadInput("--tolerance: no voxel holds " + lengthText(tolerance_) + best);
    throw BadInput("--tolerance: " + lengthText(tolerance_) + " needs about " + memoryText(needed) +
                   " of memory, and " + memoryText(double(limits_.bytes)) + " can be used" + best);
  }
  static std::string shortNumber(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.2g", value);
    return text;
  }

  double tolerance_;
  TuneLimits limits_;
  const std::function<Trial(const TuneSetting&)>& attempt_;
  std::map<std::pair<int, std::size_t>, Trial> rungs_;
};

}  // namespace

double Trial::predicted() const {
  std::vector<double> touching;
  for (std::size_t k = 0; k < depths.size(); ++k)
    if (depths[k] != kApart) touching.push_back(stated[k]);
  return quantile(std::move(touching));
}

double Trial::measured(const Trial& truth) const {
  std::vector<double> off;
  for (std::size_t k = 0; k < std::min(depths.size(), truth.depths.size()); ++k) {
    const bool apart = depths[k] == kApart, isApart = truth.depths[k] == kApart;
    if (apart && isApart) continue;
    off.push_back(std::abs((apart ? 0 : depths[k]) - (isApart ? 0 : truth.depths[k])));
  }
  return quantile(std::move(off));
}

Tuned tune(double tolerance, const TuneLimits& limits,
           const std::function<Trial(const TuneSetting&)>& attempt) {
  Ladder ladder(tolerance, limits, attempt);
  const auto [rung, samples] = ladder.choose();
  Tuned tuned;
  tuned.chosen = ladder.trial(rung, samples);
  if (limits.fixed) return tuned;
  if (rung > 0) tuned.coarser = ladder.trial(rung - 1, samples);
  if (ladder.fits(rung + 1)) tuned.finer = ladder.trial(rung + 1, samples);
  if (ladder.fits(rung + 2)) tuned.reference = ladder.trial(rung + 2, kAllSamples);
  return tuned;
}

std::size_t freeMemory() {
  std::ifstream file("/proc/meminfo");
  for (std::string name, unit; file >> name;) {
    std::size_t kilobytes = 0;
    if (name == "MemAvailable:" && file >> kilobytes) return 1024 * kilobytes;
    std::getline(file, unit);
  }
  return static_cast<std::size_t>(sysconf(_SC_PHYS_PAGES)) *
         static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) / 2;
}

}  // namespace cloudcontact::program
