// Compares the rows with the project's aims.
#include "lab/self_check.h"

#include <cmath>
#include <cstdio>

namespace cloudcontact::program::lab {
namespace {

constexpr double kDetail = 1.0 / 32;
constexpr double kMeanDeg = 0.3, kP95Deg = 1, kForce = 0.01, kTorque = 0.05;

void hold(std::vector<std::string>& faults, const ChartRow& row, const char* what, double figure,
          double limit, double factor, const char* unit) {
  if (std::isnan(figure) || figure <= limit) return;  // unknown, or within the limit
  char text[160];
  std::snprintf(text, sizeof text, ": %s %.3g %s, limit %.3g", what, factor * figure, unit,
                factor * limit);
  faults.push_back(row.name + " (" + row.setting + ")" + text);
}

}  // namespace

std::vector<std::string> ownFaults(const std::vector<ChartRow>& chart,
                                   const std::vector<StabilityRow>& stability) {
  std::vector<std::string> faults;
  for (const ChartRow& row : chart) {
    if (row.method != "cloud" || !row.smooth || std::abs(row.detail - kDetail) > 1e-9) continue;
    if (!row.why.empty() || row.missed > 0)
      faults.push_back(row.name + " (" + row.setting + "): bodies touch, no contact found");
    hold(faults, row, "mean error of the normal", row.normalDeg.mean, kMeanDeg, 1, "deg");
    hold(faults, row, "95th percentile of the normal's error", row.normalDeg.p95, kP95Deg, 1,
         "deg");
    hold(faults, row, "error of the force", row.force, kForce, 100, "%");
    hold(faults, row, "error of the torque", row.torque, kTorque, 100, "%");
  }
  for (const StabilityRow& row : stability) {
    if (row.trial.method != Method::Cloud || row.verdict.outcome != Outcome::Fails) continue;
    char text[96];
    std::snprintf(text, sizeof text, " (%s, %.0f Hz): %.3g, limit %.3g; ", row.trial.mode.c_str(),
                  1 / row.trial.step, row.verdict.figure, row.verdict.limit);
    faults.push_back(row.scene + text + row.verdict.why);
  }
  return faults;
}

}  // namespace cloudcontact::program::lab
