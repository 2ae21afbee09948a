// Means over the cases that both methods answer.
#include "lab/ratios.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

#include "lab/families.h"
#include "lab/peer_pairs.h"

namespace cloudcontact::program::lab {
namespace {

constexpr double kHullDeg = 1;  // error allowed to CloudContact beside a hull

std::string text(const char* form, double value) {
  char out[48];
  std::snprintf(out, sizeof out, form, value);
  return out;
}

std::string degrees(double value) {
  return value < 1e-3 ? "under 0.001 deg" : text("%.3g deg", value);
}

bool answers(const ChartRow& row) {
  return row.why.empty() && std::isfinite(row.microseconds) && std::isfinite(row.normalDeg.mean);
}

using Setting = std::pair<std::string, std::string>;  // method, setting
using Rows = std::vector<const ChartRow*>;

struct Family {
  std::vector<Setting> order;
  std::map<Setting, Rows> rows;
};

std::vector<std::pair<std::string, Family>> familiesOf(const std::vector<ChartRow>& rows) {
  std::vector<std::pair<std::string, Family>> families;
  for (const ChartRow& row : rows) {
    auto at = std::find_if(families.begin(), families.end(),
                           [&](const auto& f) { return f.first == row.family; });
    if (at == families.end()) at = families.insert(families.end(), {row.family, {}});
    const Setting setting = {row.method, row.setting};
    Rows& own = at->second.rows[setting];
    if (own.empty()) at->second.order.push_back(setting);
    own.push_back(&row);
  }
  return families;
}

struct Means {
  double microseconds = 0, normalDeg = 0;
  int cases = 0, wrong = 0;
};

// Means over the named cases; none if any of them is not answered.
std::optional<Means> meansOf(const Rows& rows, const std::vector<std::string>& names) {
  Means means;
  double logTime = 0;
  for (const std::string& name : names) {
    const auto row =
        std::find_if(rows.begin(), rows.end(), [&](const ChartRow* r) { return r->name == name; });
    if (row == rows.end() || !answers(**row)) return std::nullopt;
    logTime += std::log((*row)->microseconds);
    means.normalDeg += (*row)->normalDeg.mean;
    means.wrong += (*row)->wrongDepth > 0;
    ++means.cases;
  }
  if (means.cases == 0) return std::nullopt;
  means.microseconds = std::exp(logTime / means.cases);
  means.normalDeg /= means.cases;
  return means;
}

std::vector<std::string> answeredBy(const Rows& rows) {
  std::vector<std::string> names;
  for (const ChartRow* row : rows)
    if (answers(*row)) names.push_back(row->name);
  return names;
}

// `allowedDeg` is the peer's error if not given.
std::optional<PeerRatio> ratioOf(const std::string& name, const Family& family, const Setting& peer,
                                 std::optional<double> allowedDeg) {
  const Rows& rows = family.rows.at(peer);
  const std::vector<std::string> cases = answeredBy(rows);
  const auto theirs = meansOf(rows, cases);
  if (!theirs) return std::nullopt;
  PeerRatio ratio{name, peer.first, peer.second, rows.front()->convex, theirs->cases};
  ratio.of = int(rows.size()), ratio.wrong = theirs->wrong;
  ratio.microseconds = theirs->microseconds, ratio.normalDeg = theirs->normalDeg;
  ratio.allowedDeg = allowedDeg.value_or(theirs->normalDeg);
  for (const Setting& setting : family.order) {
    if (setting.first != "cloud") continue;
    const auto ours = meansOf(family.rows.at(setting), cases);
    if (!ours || ours->wrong > 0 || ours->normalDeg > ratio.allowedDeg) continue;
    if (!ratio.ours.empty() && ours->microseconds >= ratio.oursMicroseconds) continue;
    ratio.ours = setting.second;
    ratio.oursMicroseconds = ours->microseconds, ratio.oursNormalDeg = ours->normalDeg;
    ratio.timesFaster = ratio.microseconds / ratio.oursMicroseconds;
  }
  return ratio;
}

}  // namespace

std::vector<PeerRatio> peerRatios(const std::vector<ChartRow>& rows) {
  std::vector<PeerRatio> ratios;
  for (const auto& [name, family] : familiesOf(rows))
    for (const Setting& setting : family.order)
      if (!isOwn(setting.first))
        if (const auto ratio = ratioOf(name, family, setting, {})) ratios.push_back(*ratio);
  return ratios;
}

std::vector<PeerRatio> hullRatios(const std::vector<ChartRow>& rows) {
  std::vector<PeerRatio> ratios;
  for (const auto& [name, family] : familiesOf(rows))
    for (const Setting& setting : family.order) {
      const Rows& own = family.rows.at(setting);
      const bool isHull = setting.first == "gjk" && own.front()->detail == kCoarseFacets;
      if (!isHull || !own.front()->convex) continue;
      if (const auto ratio = ratioOf(name, family, setting, kHullDeg)) ratios.push_back(*ratio);
    }
  return ratios;
}

std::string verdictOf(const PeerRatio& ratio) {
  if (ratio.ours.empty()) return "no setting of CloudContact is as accurate";
  if (ratio.timesFaster >= 1) return text("%.3g times faster", ratio.timesFaster);
  return text("%.3g times slower", 1 / ratio.timesFaster);
}

std::string inWords(const PeerRatio& ratio) {
  std::string line = ratio.family + ", " + shownName(ratio.method) + " (" + ratio.setting +
                     "): " + degrees(ratio.normalDeg) + text(" in %.3g us", ratio.microseconds);
  if (ratio.cases < ratio.of)
    line += " on " + std::to_string(ratio.cases) + " of " + std::to_string(ratio.of) + " cases";
  if (ratio.wrong > 0) line += ", wrong depth on " + std::to_string(ratio.wrong);
  if (ratio.ours.empty())
    return line + "; no setting of CloudContact is within " + degrees(ratio.allowedDeg);
  return line + "; CloudContact (" + ratio.ours + ") " + degrees(ratio.oursNormalDeg) +
         text(" in %.3g us: ", ratio.oursMicroseconds) + verdictOf(ratio);
}

}  // namespace cloudcontact::program::lab
