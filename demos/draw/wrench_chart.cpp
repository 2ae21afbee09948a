// Two plots over one time axis (wrench_chart.h).
#include "draw/wrench_chart.h"

#include <algorithm>
#include <stdexcept>

#include "draw/picture_elements.h"
#include "draw/plot.h"

namespace cloudcontact::program {
namespace {

constexpr double kChartHeight = 620, kLeft = 78, kRight = kWidth - kMargin;
constexpr double kForceTop = 132, kForceEnd = 322, kTorqueTop = 376, kTorqueEnd = 566;
constexpr Color kInks[3] = {{194, 87, 26}, {42, 122, 86}, {24, 42, 66}};

void addCurves(Drawing& drawing, const std::vector<WrenchAt>& wrenches, double top, double end,
               Vec3 WrenchAt::*of, const char* name, bool timed) {
  double low = 0, high = 0;
  for (const WrenchAt& w : wrenches)
    low = std::min(low, (w.*of).minCoeff()), high = std::max(high, (w.*of).maxCoeff());
  const double margin = std::max(0.06 * (high - low), 1e-3);
  const Plot plot{{{kLeft, top}, {kRight, end}},
                  0,
                  std::max(wrenches.back().time, 1e-3),
                  low - margin,
                  high + margin};
  drawing.add(GroupBegin{timed ? "torque" : "force", {}});
  addVerticalAxis(drawing, plot, name);
  if (timed) addHorizontalAxis(drawing, plot, "time [s]");
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<Point> points;
    for (const WrenchAt& w : wrenches) points.emplace_back(w.time, (w.*of)[axis]);
    drawing.add(curve(plot, points, kInks[axis], 1.4));
  }
  drawing.add(GroupEnd{});
}

}  // namespace

Drawing wrenchChart(const std::vector<WrenchAt>& wrenches, const std::string& title,
                    const std::string& below) {
  if (wrenches.empty()) throw std::invalid_argument("wrenchChart: there is none");
  Drawing drawing{kWidth, kChartHeight, {}, {}};
  addTitle(drawing, title, below);
  const double y = kForceTop - 9;
  for (int axis = 0; axis < 3; ++axis) {
    const double x = kRight - 190 + 66 * axis;
    drawing.add(line({x, y - 5}, {x + 26, y - 5}, kInks[axis], 2));
    drawing.add(Text{{x + 34, y}, std::string(1, "xyz"[axis]), kSmallText, kFaintInk});
  }
  addCurves(drawing, wrenches, kForceTop, kForceEnd, &WrenchAt::force, "Force [N]", false);
  addCurves(drawing, wrenches, kTorqueTop, kTorqueEnd, &WrenchAt::torque, "Torque [N m]", true);
  return drawing;
}

}  // namespace cloudcontact::program
