// The counts of the last commit, benchmarks/work.json, and what has changed since.
#pragma once

#include <string>
#include <vector>

#include "io/json.h"
#include "lab/work.h"

namespace cloudcontact::program::lab {

// A count that is larger by more than this share is a fault, one that is smaller by more is good
// news. Each line names the entry and the count. A fault, too, is an entry that the file lacks.
inline constexpr double kWorkGrows = 0.03;
struct WorkChanges {
  std::vector<std::string> faults, news;
};
WorkChanges compared(const Json& before, const std::vector<WorkEntry>& now);

// The file's text, an entry a line. Entries of `before` that are not in `now` stay.
std::string workText(const Json& before, const std::vector<WorkEntry>& now);

// {name: {us, gimpact, gather}}, in microseconds.
Json timesJson(const std::vector<WorkTime>& times);

}  // namespace cloudcontact::program::lab
