// Builds the HTML page from JSON and the pictures.
#include "lab/report.h"

#include <cmath>
#include <cstdio>
#include <map>

#include "io/text.h"
#include "lab/families.h"

namespace cloudcontact::program::lab {
namespace {

constexpr const char* kStyle =
    "body{font:15px/1.5 system-ui,'DejaVu Sans',sans-serif;margin:0 "
    "auto;max-width:1180px;padding:1rem;color:#20242c}svg{max-width:100%;height:auto}table{border-"
    "collapse:collapse;font-size:13px;margin:.5rem "
    "0}td,th{padding:.15rem .6rem;border-bottom:1px solid "
    "#dfe2e7;text-align:right;white-space:nowrap}td:nth-child(-n+3),th:nth-child(-n+3){text-align:"
    "left}.holds{color:#2d7a4f}.fails{color:#b3273b;font-weight:600}.cannot{color:#777}.wrapped "
    "td{white-space:normal}code{background:#eef0f3;padding:.1rem "
    ".3rem}details{margin:.4rem 0}.scroll{overflow-x:auto}small{color:#666}";

bool isKnown(const Json& value) {
  return value.is_number() && std::isfinite(value.get<double>());
}

// A number in a table: three digits, or a dash where it is not known.
std::string cell(const Json& value, double factor = 1) {
  if (!isKnown(value)) return "\u2013";
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", factor * value.get<double>());
  return text;
}

std::string row(const std::vector<std::string>& cells, const char* tag = "td",
                const std::string& group = "") {
  std::string out = group.empty() ? "<tr>" : "<tr class=\"" + group + "\">";
  for (const std::string& c : cells) out += std::string("<") + tag + ">" + c + "</" + tag + ">";
  return out + "</tr>\n";
}

// "1280 + 2112"; a dash where the method takes no triangles.
std::string trianglesOf(const Json& r) {
  const auto a = r["triangles"][0].get<std::size_t>(), b = r["triangles"][1].get<std::size_t>();
  return a + b == 0 ? "\u2013" : std::to_string(a) + " + " + std::to_string(b);
}

std::string chartTable(const Json& chart) {
  std::string out =
      "<div class=scroll><table>" +
      row({"case", "method", "setting", "triangles", "\u00b5s", "normal mean \u00b0", "p95 \u00b0",
           "max \u00b0", "depth \u00b5m", "depth / true", "center \u00b5m", "force %", "torque %",
           "swapped \u00b0", "loop work %", "volume %"},
          "th");
  for (const Json& r : chart["rows"]) {
    const std::string name = asHtml(r["case"].get<std::string>());
    const std::string method = asHtml(shownName(r["method"].get<std::string>()));
    const std::string setting = asHtml(r["setting"].get<std::string>());
    const std::string why = r["why"].get<std::string>();
    if (!why.empty()) {
      out += "<tr class=cannot><td>" + name + "</td><td>" + method + "</td><td>" + setting +
             "</td><td colspan=13 style=\"text-align:left;white-space:normal\">" + asHtml(why) +
             "</td></tr>\n";
      continue;
    }
    out += row({name, method, setting, trianglesOf(r), cell(r["microseconds"]),
                cell(r["normalDeg"]["mean"]), cell(r["normalDeg"]["p95"]),
                cell(r["normalDeg"]["max"]), cell(r["depth"], 1e6), cell(r["depthTimes"]),
                cell(r["centre"], 1e6), cell(r["force"], 100), cell(r["torque"], 100),
                cell(r["swappedNormalDeg"]), cell(r["loopWork"], 100), cell(r["volume"], 100)});
  }
  return out + "</table></div>";
}

// The solvers differ, which the comparison must state.
constexpr const char* kSolvers =
    "<p>CloudContact's worlds use this project's NewtonSolver, which solves all rows together; "
    "the others Bullet's own solver with its ten sweeps of sequential impulses."
    "</p>";

std::string failuresTable(const Json& failures) {
  std::string out =
      "<div class=scroll><table>" +
      row({"scene", "rule", "method", "mode", "Hz", "outcome", "figure", "limit", "why"}, "th");
  for (const Json& r : failures["rows"])
    out += row({asHtml(r["scene"].get<std::string>()), asHtml(r["rule"].get<std::string>()),
                asHtml(r["method"].get<std::string>()), asHtml(r["mode"].get<std::string>()),
                cell(Json(1 / r["step"].get<double>())), r["outcome"].get<std::string>(),
                cell(r["figure"]), cell(r["limit"]), asHtml(r["why"].get<std::string>())},
               "td", r["outcome"].get<std::string>());
  return out + "</table></div>";
}

std::string textOf(const Json& object, const char* field) {
  return asHtml(object[field].get<std::string>());
}

std::string methodOf(const Json& row) {
  return asHtml(shownName(row["method"].get<std::string>()));
}

std::string runningTable(const Json& failures) {
  std::string out = "<div class=scroll><table>" + row({"scene", "method", "mode", "Hz", "outcome",
                                                       "narrow phase \u00b5s", "step \u00b5s"},
                                                      "th");
  for (const Json& r : failures["rows"]) {
    if (!r["timed"].get<bool>() || r["steps"].get<long>() == 0) continue;
    const std::string outcome = r["outcome"].get<std::string>();
    out += row({textOf(r, "scene"), methodOf(r), textOf(r, "mode"),
                cell(Json(1 / r["step"].get<double>())), outcome,
                cell(r["narrowPhaseMicroseconds"]), cell(r["stepMicroseconds"])},
               "td", outcome);
  }
  return out + "</table></div>";
}

std::string runningText(const Json& failures, const std::string& picture) {
  return "<h2>Running scenes</h2><p>What a step costs where bodies move: each scene's cheapest "
         "trial that holds, which means that it reaches the same end within the scene's limits. "
         "Where none holds, the cheapest, hatched. These trials ran one at a time, on one "
         "thread.</p>" +
         picture + "<details><summary>All of their trials</summary>" + runningTable(failures) +
         "</details>";
}

std::string tally(const Json& failures) {
  std::map<std::string, std::map<std::string, int>> counts;
  for (const Json& r : failures["rows"])
    ++counts[r["method"].get<std::string>()][r["outcome"].get<std::string>()];
  std::string out = "<ul>";
  for (auto& [method, count] : counts)
    out += "<li><b>" + asHtml(method) + "</b>: " + std::to_string(count["holds"]) + " hold, " +
           std::to_string(count["fails"]) + " fail, " + std::to_string(count["cannot"]) +
           " cannot run</li>";
  return out + "</ul>";
}

std::string ratiosTable(const Json& ratios) {
  if (ratios.empty()) return "<p>This run has nothing to compare.</p>";
  std::string out = "<div class=scroll><table>" +
                    row({"family", "peer", "setting", "cases", "peer \u00b0", "peer \u00b5s",
                         "CloudContact setting", "\u00b0", "\u00b5s", "CloudContact is"},
                        "th");
  for (const Json& r : ratios) {
    const Json& times = r["timesFaster"];
    const bool none = !isKnown(times);
    const bool slower = !none && times.get<double>() < 1;
    const double shown = none ? 0 : slower ? 1 / times.get<double>() : times.get<double>();
    const std::string verdict =
        none ? "never as accurate"
             : cell(Json(shown)) + (slower ? " times slower" : " times faster");
    std::string cases = std::to_string(r["cases"].get<int>());
    cases += " of " + std::to_string(r["of"].get<int>());
    if (r["wrong"].get<int>() > 0)
      cases += ", wrong depth on " + std::to_string(r["wrong"].get<int>());
    out += row({textOf(r, "family"), methodOf(r), textOf(r, "setting"), cases, cell(r["normalDeg"]),
                cell(r["microseconds"]), textOf(r, "ours"), cell(r["oursNormalDeg"]),
                cell(r["oursMicroseconds"]), verdict},
               "td",
               r["wrong"].get<int>() > 0 ? "cannot"
               : none || slower          ? "fails"
                                         : "holds");
  }
  return out + "</table></div>";
}

Json ofFamilies(const Json& ratios, bool convex) {
  Json some = Json::array();
  for (const Json& r : ratios)
    if (r["convex"].get<bool>() == convex) some.push_back(r);
  return some;
}

std::string ratiosText(const Json& chart) {
  return "<h2>How many times faster, at the same error</h2><p>Each line compares one setting "
         "of a peer with the fastest setting of CloudContact whose normals are at least as "
         "accurate, over the cases that the peer answers. Times are geometric means, errors "
         "arithmetic means. Peers with a wrong depth are still compared by their normals; "
         "their lines are gray.</p><h3>Concave families</h3>" +
         ratiosTable(ofFamilies(chart["ratios"], false)) +
         "<h3>Convex families, against GJK and EPA on the hull of the coarsest mesh</h3><p>On "
         "spheres that hull has 642 vertices. CloudContact may be off by 1\u00b0 here, "
         "whatever the hull's error.</p>" +
         ratiosTable(chart["hullRatios"]) +
         "<details><summary>Convex families, against all settings, at the peer's own "
         "error</summary>" +
         ratiosTable(ofFamilies(chart["ratios"], true)) + "</details>";
}

std::string settingsText(const Json& chart) {
  std::string out = "<details><summary>Settings of each method</summary><p>" +
                    textOf(chart, "metreScale") + "</p><div class=scroll><table class=wrapped>" +
                    row({"method", "setting", "description", "scaled to 1 m"}, "th");
  for (const Json& m : chart["methods"])
    out += row({methodOf(m), textOf(m, "setting"), textOf(m, "told"),
                m["metreScale"].get<bool>() ? "yes" : "no"});
  return out + "</table></div></details>";
}

std::string setupText(const Json& chart) {
  const Json& m = chart["machine"];
  std::string versions;
  for (const auto& [name, version] : chart["versions"].items())
    versions +=
        (versions.empty() ? "" : ", ") + asHtml(name) + " " + asHtml(version.get<std::string>());
  return "<p><small>" + textOf(m, "processor") + ", " + std::to_string(m["threads"].get<int>()) +
         " threads; " + versions + "; <code>" + textOf(chart, "command") + "</code>, " +
         cell(chart["seconds"]) +
         " s. All methods ran in this run; times were measured on one thread with nothing "
         "else of the run beside it.</small></p>";
}

std::string listOf(const Json& lines, const std::string& otherwise) {
  std::string out = "<ul>";
  for (const Json& line : lines) out += "<li>" + asHtml(line.get<std::string>()) + "</li>";
  if (lines.empty()) out += "<li>" + otherwise + "</li>";
  return out + "</ul>";
}

std::string pictureText(const ReportPictures& pictures) {
  return "<h2>Error against time</h2><p>Each mark is a method at one setting. Its error is "
         "the mean over the cases, grids and depths of a family; its time is the geometric "
         "mean over the cases. Lower left is better. Numbers beside CloudContact's marks are "
         "voxels per body size; peers that take meshes have one mark per facet tolerance. A "
         "hollow mark leaves out cases that the method cannot do. A cross marks a depth that "
         "is wrong by more than half the body's size, or a missed contact: such a method is "
         "neither on the frontier nor recommended, however accurate its "
         "normals.</p><p>CloudContact's normals are the fitted normals of its surface "
         "samples; marked apart, the base vectors of the paper, by the radius of their "
         "window.</p>" +
         pictures.chart +
         "<p>The same for force and torque, where their true values are known.</p>" +
         pictures.force;
}

}  // namespace

std::string reportHtml(const Json& chart, const Json& failures, const ReportPictures& pictures) {
  const std::string title = chart.contains("subject")
                                ? "Contact of " + chart["subject"].get<std::string>()
                                : "Contact methods: speed, accuracy and stability";
  std::string out =
      "<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport "
      "content=\"width=device-width\"><title>" +
      asHtml(title) + "</title><style>" + kStyle + "</style>\n<h1>" + asHtml(title) + "</h1>" +
      setupText(chart) + settingsText(chart);
  out += "<h2>Which method to use</h2>" + listOf(chart["advice"], "no cases were run");
  out += "<h2>Where CloudContact misses its own aims</h2>" +
         listOf(chart["fallsShort"], "nowhere in this run");
  out += ratiosText(chart) + pictureText(pictures);
  if (!pictures.failures.empty())
    out += "<h2>Stability</h2>" + tally(failures) + kSolvers + pictures.failures +
           "<details><summary>All trials, with rules and limits</summary>" +
           failuresTable(failures) + "</details>";
  if (!pictures.running.empty()) out += runningText(failures, pictures.running);
  out += "<details><summary>All cases in numbers</summary>" + chartTable(chart) + "</details>";
  out +=
      "<h2>Your own pair</h2><p><code>cloudcontact chart A.stl B.stl --pose \"x y z qx qy "
      "qz qw\" --out DIR</code> draws this chart for two meshes of yours. Their true "
      "contact is not known, so CloudContact at its finest voxels is the "
      "reference.</p></html>\n";
  return out;
}

}  // namespace cloudcontact::program::lab
