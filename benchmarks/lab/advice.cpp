// Words from figures: nothing here knows a method by its merits.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "lab/chart_files.h"
#include "lab/families.h"

namespace cloudcontact::program::lab {
namespace {

std::string text(const char* form, double value) {
  char out[48];
  std::snprintf(out, sizeof out, form, value);
  return out;
}

std::string described(const FamilyMark& m) {
  const std::string error = m.normalDeg < 1e-3 ? "under 0.001 deg" : text("%.3g deg", m.normalDeg);
  return shownName(m.method) + " (" + m.setting + "), " + error + " in " +
         text("%.3g us", m.microseconds);
}

// "73", or "54 to 73".
std::string range(double low, double high) {
  const auto number = [](double v) { return text(v < 9.5 ? "%.2g" : "%.0f", v); };
  const std::string from = number(low), to = number(high);
  return from == to ? from : from + " to " + to;
}

// Said aloud: by their normals alone such methods would be recommended.
std::string wrongDepths(const std::vector<const FamilyMark*>& marks) {
  std::map<std::string, std::pair<double, double>> methods;
  for (const FamilyMark* m : marks) {
    if (!(m->depthTimes > 0)) continue;
    const auto [known, isNew] = methods.try_emplace(m->method, m->depthTimes, m->depthTimes);
    known->second.first = std::min(known->second.first, m->depthTimes);
    known->second.second = std::max(known->second.second, m->depthTimes);
  }
  std::string all;
  for (const auto& [method, times] : methods)
    all +=
        (all.empty() ? " Left out, as depths of theirs are wrong whatever their normals: " : ", ") +
        shownName(method) + " (" + range(times.first, times.second) + " times the true depth)";
  return all.empty() ? all : all + ".";
}

// The fastest that stays under an error; none where nothing does.
const FamilyMark* fastestUnder(const std::vector<const FamilyMark*>& marks, double degrees) {
  const FamilyMark* best = nullptr;
  for (const FamilyMark* m : marks)
    if (m->normalDeg <= degrees && (!best || m->microseconds < best->microseconds)) best = m;
  return best;
}

}  // namespace

std::vector<std::string> advice(const std::vector<ChartRow>& rows) {
  const std::vector<FamilyMark> marks = familyMarks(rows);
  std::vector<std::string> families;
  std::map<std::string, std::vector<const FamilyMark*>> whole, all;
  for (const FamilyMark& m : marks) {
    if (std::find(families.begin(), families.end(), m.family) == families.end())
      families.push_back(m.family);
    all[m.family].push_back(&m);
    if (m.whole() && std::isfinite(m.normalDeg)) whole[m.family].push_back(&m);
  }
  std::vector<std::string> lines;
  for (const std::string& family : families) {
    const auto& able = whole[family];
    if (able.empty()) {
      lines.push_back(family + ": no method answers all of its cases rightly.");
      continue;
    }
    const FamilyMark* best = *std::min_element(
        able.begin(), able.end(), [](auto* a, auto* b) { return a->normalDeg < b->normalDeg; });
    std::string line = family + ": most accurate " + described(*best);
    const FamilyMark *rough = fastestUnder(able, 5), *fine = fastestUnder(able, 1);
    if (fine) line += "; fastest within 1 deg " + described(*fine);
    if (rough && rough != fine) line += "; fastest within 5 deg " + described(*rough);
    if (!rough) line += "; none stays within 5 deg";
    line += ".";
    lines.push_back(line + wrongDepths(all[family]));
  }
  return lines;
}

}  // namespace cloudcontact::program::lab
