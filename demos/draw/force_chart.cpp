// Draws three plots over one time axis, with a ribbon of tissues below the first.
#include "draw/force_chart.h"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <utility>

#include "draw/picture_elements.h"
#include "draw/plot.h"
#include "draw/tissue_colors.h"

namespace cloudcontact::program {

namespace {

constexpr double kChartHeight = 760, kLeft = 78, kRight = kWidth - kMargin;
constexpr double kForceTop = 122, kForceEnd = 352, kRibbonEnd = 376;
constexpr double kWayTop = 424, kWayEnd = 542, kVolumeTop = 590, kVolumeEnd = 700;
constexpr Color kForceInk{24, 42, 66}, kWayInk{24, 42, 66}, kLawInk{194, 87, 26};

Plot plotOf(const CuttingRun& run, double top, double end, double low, double high) {
  const double last = std::max(run.ticks.back().time, run.step);
  return {{{kLeft, top}, {kRight, end}}, 0, last, low, high};
}

// Ranges of ticks within one px: first and one past the last.
std::vector<std::pair<std::size_t, std::size_t>> columnsOf(const CuttingRun& run,
                                                           const Plot& plot) {
  std::vector<std::pair<std::size_t, std::size_t>> columns;
  const auto count = static_cast<std::size_t>(std::max(1.0, plot.frame.size().x()));
  for (std::size_t c = 0; c < count; ++c) {
    const std::size_t first = c * run.ticks.size() / count,
                      end = (c + 1) * run.ticks.size() / count;
    if (end > first) columns.emplace_back(first, end);
  }
  return columns;
}

std::vector<double> meanShares(const CuttingRun& run, std::pair<std::size_t, std::size_t> column) {
  std::vector<double> sums(run.tissues.size(), 0.0);
  for (std::size_t k = column.first; k < column.second; ++k)
    for (std::size_t t = 0; t < sums.size(); ++t)
      sums[t] += static_cast<double>(run.sharesAt(k)[t]) /
                 static_cast<double>(column.second - column.first);
  return sums;
}

// The background of the force in the color of the tissue touched most.
void addGround(Drawing& drawing, const CuttingRun& run, const Plot& plot,
               const std::vector<Color>& colors) {
  std::map<std::size_t, Polygons> areas;
  for (const auto& column : columnsOf(run, plot)) {
    const std::vector<double> shares = meanShares(run, column);
    const auto most =
        static_cast<std::size_t>(std::max_element(shares.begin(), shares.end()) - shares.begin());
    if (!(shares[most] > 0)) continue;
    double force = 0;
    for (std::size_t k = column.first; k < column.second; ++k)
      force = std::max(force, run.ticks[k].force.norm());
    const double left = plot.x(run.ticks[column.first].time),
                 right = plot.x(run.ticks[column.second - 1].time + run.step);
    areas[most].paint = {colors[most], std::nullopt, 0};
    areas[most].rings.push_back(ringOf({{left, plot.y(force)}, {right, plot.y(0)}}));
  }
  for (auto& [tissue, polygons] : areas) drawing.add(std::move(polygons));
}

// The share of each tissue among the touched voxels, from 0 to 1.
void addRibbon(Drawing& drawing, const CuttingRun& run, const Rectangle& frame, const Plot& plot,
               const std::vector<Color>& colors) {
  std::vector<Polygons> stripes(colors.size());
  for (const auto& column : columnsOf(run, plot)) {
    const std::vector<double> shares = meanShares(run, column);
    double low = frame.high.y();
    for (std::size_t t = 0; t < shares.size(); ++t) {
      const double high = low - shares[t] * frame.size().y();
      if (shares[t] > 1e-3)
        stripes[t].rings.push_back(
            ringOf({{plot.x(run.ticks[column.first].time), high},
                    {plot.x(run.ticks[column.second - 1].time + run.step), low}}));
      low = high;
    }
  }
  for (std::size_t t = 0; t < stripes.size(); ++t) {
    stripes[t].paint = {colors[t], std::nullopt, 0};
    if (!stripes[t].rings.empty()) drawing.add(std::move(stripes[t]));
  }
  drawing.add(Polygons{{ringOf(frame)}, {std::nullopt, kRule, 1}});
}

void addForce(Drawing& drawing, const CuttingRun& run, const std::vector<Color>& colors) {
  double most = 0;
  std::vector<Point> force;
  for (const CuttingTick& t : run.ticks) {
    force.emplace_back(t.time, t.force.norm());
    most = std::max(most, t.force.norm());
  }
  const Plot plot = plotOf(run, kForceTop, kForceEnd, 0, most > 0 ? 1.08 * most : 1);
  drawing.add(GroupBegin{"force", {}});
  addVerticalAxis(drawing, plot, "Force on the hand [N], over the tissue touched most");
  addGround(drawing, run, plot, colors);
  drawing.add(curve(plot, force, kForceInk, 1.2));
  drawing.add(GroupEnd{});
  drawing.add(GroupBegin{"tissues", {}});
  addRibbon(drawing, run, {{kLeft, kForceEnd + 6}, {kRight, kRibbonEnd}}, plot, colors);
  drawing.add(Text{{kLeft - 8, kRibbonEnd - 5}, "touched", kSmallText, kFaintInk, Align::Right});
  drawing.add(GroupEnd{});
}

void addWay(Drawing& drawing, const CuttingRun& run, const ForceChartText& words) {
  Vec3 start = run.ticks.front().tool;
  for (const CuttingTick& t : run.ticks)
    if (t.depth > 0) {
      start = t.tool;
      break;
    }
  std::vector<Point> way;
  double least = 0, most = 0;
  for (const CuttingTick& t : run.ticks) {
    way.emplace_back(t.time, 1e3 * words.inward.dot(t.tool - start));
    least = std::min(least, way.back().y()), most = std::max(most, way.back().y());
  }
  const double margin = 0.06 * std::max(most - least, 1e-3);
  // Depth increases downward.
  const Plot plot = plotOf(run, kWayTop, kWayEnd, most + margin, least - margin);
  drawing.add(GroupBegin{"way", {}});
  addVerticalAxis(drawing, plot, words.way);
  drawing.add(curve(plot, way, kWayInk, 1.5));
  drawing.add(GroupEnd{});
}

void addVolume(Drawing& drawing, const CuttingRun& run) {
  std::vector<Point> gone, law;
  for (const CuttingTick& t : run.ticks) {
    gone.emplace_back(t.time, 1e9 * t.cut);
    law.emplace_back(t.time, 1e9 * t.work);
  }
  const double most = std::max({gone.back().y(), law.back().y(), 1e-6});
  const Plot plot = plotOf(run, kVolumeTop, kVolumeEnd, 0, 1.08 * most);
  drawing.add(GroupBegin{"volume", {}});
  addVerticalAxis(drawing, plot, "Volume [mm\u00b3]");
  addHorizontalAxis(drawing, plot, "time [s]");
  drawing.add(curve(plot, law, kLawInk, 4));
  drawing.add(curve(plot, gone, kPaperWhite, 1.4));
  drawing.add(curve(plot, gone, kForceInk, 1.2));
  const double y = kVolumeTop - 9;
  const auto key = [&](double x, const Color& color, double width, const char* says) {
    drawing.add(line({x, y - 5}, {x + 26, y - 5}, color, width));
    drawing.add(Text{{x + 34, y}, says, kSmallText, kFaintInk});
  };
  key(kLeft + 130, kForceInk, 1.2, "removed");
  key(kLeft + 270, kLawInk, 4,
      "Archard's law for the work done: efficiency \u00d7 force \u00d7 way / hardness");
  drawing.add(GroupEnd{});
}

}  // namespace

Drawing forceChart(const CuttingRun& run, const ForceChartText& words) {
  if (run.ticks.empty()) throw std::invalid_argument("forceChart: the run has no ticks");
  const std::vector<Color> colors = tissueColors(run.tissues);
  Drawing drawing{kWidth, kChartHeight, {}, {}};
  addTitle(drawing, words.title, words.below);
  drawing.add(GroupBegin{"key", {}});
  double x = kWidth - kMargin;
  for (const std::string& name : run.tissues) x -= 42 + widthOf(shortName(name, 20), kTextSize);
  for (std::size_t t = 0; t < run.tissues.size(); ++t)
    x = addTissueKey(drawing, {x, kForceTop - 11}, run.tissues[t], colors[t]);
  drawing.add(GroupEnd{});
  addForce(drawing, run, colors);
  addWay(drawing, run, words);
  addVolume(drawing, run);
  return drawing;
}

}  // namespace cloudcontact::program
