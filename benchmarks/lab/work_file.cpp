// Compares count by count.
#include "lab/work_file.h"

#include <cstdio>

namespace cloudcontact::program::lab {
namespace {

std::string changeText(const std::string& entry, const std::string& count, double was, double is) {
  char text[160];
  std::snprintf(text, sizeof text, ": %s %.6g, was %.6g", count.c_str(), is, was);
  std::string line = entry + text;
  if (was > 0) {
    std::snprintf(text, sizeof text, " (%+.1f %%)", 100 * (is / was - 1));
    line += text;
  }
  return line;
}

// So that texts of the same counts are equal.
double rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.7g", value);
  return std::stod(text);
}

}  // namespace

WorkChanges compared(const Json& before, const std::vector<WorkEntry>& now) {
  WorkChanges changes;
  for (const WorkEntry& entry : now) {
    if (!before.contains(entry.name)) {
      changes.faults.push_back(entry.name + ": not in the file");
      continue;
    }
    const Json& old = before[entry.name];
    for (const auto& [count, is] : entry.counts) {
      const double was = old.value(count, 0.0);
      const std::string line = changeText(entry.name, count, was, is);
      if (is > (1 + kWorkGrows) * was) changes.faults.push_back(line);
      if (is < (1 - kWorkGrows) * was) changes.news.push_back(line);
    }
  }
  return changes;
}

std::string workText(const Json& before, const std::vector<WorkEntry>& now) {
  Json all = before;
  for (const WorkEntry& entry : now) {
    Json& counts = all[entry.name] = Json::object();
    for (const auto& [count, is] : entry.counts) counts[count] = rounded(is);
  }
  std::string text = "{";
  for (const auto& [name, counts] : all.items())
    text +=
        (text.size() > 1 ? ",\n" : "\n") + jsonText(Json(name), -1) + ": " + jsonText(counts, -1);
  return text + "\n}\n";
}

Json timesJson(const std::vector<WorkTime>& times) {
  Json all = Json::object();
  for (const WorkTime& time : times)
    all[time.name] = {
        {"us", 1e6 * time.seconds}, {"gimpact", 1e6 * time.gimpact}, {"gather", 1e6 * time.gather}};
  return all;
}

}  // namespace cloudcontact::program::lab
