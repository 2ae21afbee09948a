// Groups rows by family, method and setting, and words the advice from their figures alone.
#include "lab/families.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <tuple>

namespace cloudcontact::program::lab {
namespace {

using Rows = std::vector<const ChartRow*>;

FamilyMark markOf(const Rows& rows) {
  const ChartRow& first = *rows.front();
  FamilyMark mark{first.family, first.method, first.setting};
  double logTime = 0;
  int wrongDepths = 0;
  for (const ChartRow* row : rows) {
    if (!row->why.empty()) {
      ++mark.cannot;
      continue;
    }
    ++mark.cases;
    if (row->wrongDepth > 0 || row->missed > 0) ++mark.wrong;
    if (row->wrongDepth > 0) ++wrongDepths, mark.depthTimes += row->depthTimes;
    logTime += std::log(row->microseconds);
    mark.normalDeg += row->normalDeg.mean;
    const double force = std::isnan(row->force) ? 0 : row->force;
    mark.wrench += std::max(force, std::isnan(row->torque) ? 0 : row->torque);
  }
  if (wrongDepths > 0) mark.depthTimes /= wrongDepths;
  if (mark.cases > 0) {
    mark.microseconds = std::exp(logTime / mark.cases);
    mark.normalDeg /= mark.cases, mark.wrench /= mark.cases;
  }
  return mark;
}

bool beats(const FamilyMark& one, const FamilyMark& other) {
  return one.family == other.family && one.whole() && one.microseconds < other.microseconds &&
         one.normalDeg < other.normalDeg;
}

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

// Names the methods with wrong depths: by their normals alone they would be recommended.
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
    all += (all.empty() ? " Left out because of wrong depths: " : ", ") + shownName(method) + " (" +
           range(times.first, times.second) + " times the true depth)";
  return all.empty() ? all : all + ".";
}

// The fastest mark within an error; null if there is none.
const FamilyMark* fastestUnder(const std::vector<const FamilyMark*>& marks, double degrees) {
  const FamilyMark* best = nullptr;
  for (const FamilyMark* m : marks)
    if (m->normalDeg <= degrees && (!best || m->microseconds < best->microseconds)) best = m;
  return best;
}

}  // namespace

std::string shownName(const std::string& method) {
  static const std::map<std::string, std::string> names = {{"cloud", "CloudContact"},
                                                           {"paper", "CloudContact, base vectors"},
                                                           {"primitive", "Bullet's primitives"},
                                                           {"gjk", "Bullet GJK/EPA"},
                                                           {"gimpact", "Bullet GImpact"},
                                                           {"hacd", "Bullet, HACD parts"},
                                                           {"sdf", "Bullet btSdf"},
                                                           {"fcl", "FCL"},
                                                           {"ode", "ODE"},
                                                           {"mujoco", "MuJoCo"}};
  const auto known = names.find(method);
  return known == names.end() ? method : known->second;
}

std::vector<FamilyMark> familyMarks(const std::vector<ChartRow>& rows) {
  using Key = std::tuple<std::string, std::string, std::string>;
  std::map<Key, Rows> groups;
  std::vector<Key> order;
  for (const ChartRow& row : rows) {
    Rows& group = groups[{row.family, row.method, row.setting}];
    if (group.empty()) order.emplace_back(row.family, row.method, row.setting);
    group.push_back(&row);
  }
  std::vector<FamilyMark> marks;
  for (const Key& key : order) marks.push_back(markOf(groups[key]));
  for (FamilyMark& one : marks)
    one.frontier = one.whole() && std::none_of(marks.begin(), marks.end(), [&](const auto& other) {
                     return beats(other, one);
                   });
  return marks;
}

void markFrontier(std::vector<ChartRow>& rows) {
  for (const FamilyMark& mark : familyMarks(rows))
    for (ChartRow& row : rows)
      if (row.family == mark.family && row.method == mark.method && row.setting == mark.setting)
        row.frontier = mark.frontier;
}

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
      lines.push_back(family + ": no method answers all cases correctly.");
      continue;
    }
    const FamilyMark* best = *std::min_element(
        able.begin(), able.end(), [](auto* a, auto* b) { return a->normalDeg < b->normalDeg; });
    std::string line = family + ": most accurate " + described(*best);
    const FamilyMark *rough = fastestUnder(able, 5), *fine = fastestUnder(able, 1);
    if (fine) line += "; fastest within 1 deg " + described(*fine);
    if (rough && rough != fine) line += "; fastest within 5 deg " + described(*rough);
    if (!rough) line += "; none is within 5 deg";
    line += ".";
    lines.push_back(line + wrongDepths(all[family]));
  }
  return lines;
}

}  // namespace cloudcontact::program::lab
