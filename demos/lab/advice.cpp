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
  return m.method + " (" + m.setting + "), " + error + " in " + text("%.3g us", m.microseconds);
}

// Said aloud: by its normal alone such a method would be recommended.
std::string wrongDepthOf(const FamilyMark& m) {
  return "Not " + m.method + " (" + m.setting + "): it reports a normal " +
         text("%.3g deg", m.normalDeg) + " off, but on " + std::to_string(m.wrong) + " of " +
         std::to_string(m.cases) + " cases " + text("%.3g times the true depth.", m.depthTimes);
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
  std::map<std::string, std::vector<const FamilyMark*>> whole;
  for (const FamilyMark& m : marks) {
    if (std::find(families.begin(), families.end(), m.family) == families.end())
      families.push_back(m.family);
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
    for (const FamilyMark& m : marks)
      if (m.family == family && m.depthTimes > 0) line += " " + wrongDepthOf(m);
    lines.push_back(line);
  }
  return lines;
}

}  // namespace cloudcontact::program::lab
