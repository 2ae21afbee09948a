// Groups rows by family, method and setting.
#include "lab/families.h"

#include <algorithm>
#include <cmath>
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

}  // namespace

std::string shownName(const std::string& method) {
  static const std::map<std::string, std::string> names = {{"cloud", "CloudContact"},
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

}  // namespace cloudcontact::program::lab
