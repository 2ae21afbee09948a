// HTML put together from JSON: words, pictures, tables.
#include "lab/report.h"

#include <cmath>
#include <cstdio>
#include <map>

#include "io/text.h"
#include "lab/chart.h"

namespace cloudcontact::program::lab {
namespace {

constexpr const char* kStyle =
    "body{font:15px/1.5 system-ui,'DejaVu Sans',sans-serif;margin:0 auto;max-width:1180px;"
    "padding:1rem;color:#20242c}svg{max-width:100%;height:auto}table{border-collapse:collapse;"
    "font-size:13px;margin:.5rem 0}td,th{padding:.15rem .6rem;border-bottom:1px solid #dfe2e7;"
    "text-align:right;white-space:nowrap}td:nth-child(-n+3),th:nth-child(-n+3){text-align:left}"
    ".holds{color:#2d7a4f}.fails{color:#b3273b;font-weight:600}.cannot{color:#777}"
    ".wrapped td{white-space:normal}"
    "code{background:#eef0f3;padding:.1rem .3rem}details{margin:.4rem 0}.scroll{overflow-x:auto}"
    "small{color:#666}";

bool isKnown(const Json& value) {
  return value.is_number() && std::isfinite(value.get<double>());
}

// A figure of a table: three digits, a dash where nothing is known.
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

// "1280 + 2112"; a dash where a method takes none.
std::string trianglesOf(const Json& r) {
  const auto a = r["triangles"][0].get<std::size_t>(), b = r["triangles"][1].get<std::size_t>();
  return a + b == 0 ? "\u2013" : std::to_string(a) + " + " + std::to_string(b);
}

std::string chartTable(const Json& chart) {
  std::string out =
      "<div class=scroll><table>" +
      row({"case", "method", "setting", "triangles", "\u00b5s", "normal mean \u00b0", "p95 \u00b0",
           "max \u00b0", "depth \u00b5m", "depth / true", "centre \u00b5m", "force %", "torque %",
           "swapped \u00b0", "loop's work %", "volume %"},
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

// Part of what is compared, and not of the contacts.
constexpr const char* kSolvers =
    "<p>Each world takes ten sweeps of sequential impulses a step. Cloud's worlds have "
    "ExtrapolatingSolver, which is this project's too, the others Bullet's own.</p>";

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

std::string tally(const Json& failures) {
  std::map<std::string, std::map<std::string, int>> counts;
  for (const Json& r : failures["rows"])
    ++counts[r["method"].get<std::string>()][r["outcome"].get<std::string>()];
  std::string out = "<ul>";
  for (auto& [method, count] : counts)
    out += "<li><b>" + asHtml(method) + "</b>: " + std::to_string(count["holds"]) + " hold, " +
           std::to_string(count["fails"]) + " fail, " + std::to_string(count["cannot"]) +
           " cannot</li>";
  return out + "</ul>";
}

std::string textOf(const Json& object, const char* field) {
  return asHtml(object[field].get<std::string>());
}

std::string methodOf(const Json& row) {
  return asHtml(shownName(row["method"].get<std::string>()));
}

std::string ratiosTable(const Json& ratios) {
  if (ratios.empty()) return "<p>Nothing to compare in what was run.</p>";
  std::string out = "<div class=scroll><table>" +
                    row({"family", "peer", "setting", "cases", "its \u00b0", "its \u00b5s", "ours",
                         "our \u00b0", "our \u00b5s", "ours is"},
                        "th");
  for (const Json& r : ratios) {
    const Json& times = r["timesFaster"];
    const bool none = !isKnown(times);
    const bool slower = !none && times.get<double>() < 1;
    const double shown = none ? 0 : slower ? 1 / times.get<double>() : times.get<double>();
    const std::string verdict =
        none ? "none as accurate"
             : cell(Json(shown)) + (slower ? " times slower" : " times faster");
    std::string cases = std::to_string(r["cases"].get<int>());
    cases += " of " + std::to_string(r["of"].get<int>());
    if (r["wrong"].get<int>() > 0)
      cases += ", depth wrong on " + std::to_string(r["wrong"].get<int>());
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
  return "<h2>How many times faster, at the same error</h2><p>Against each setting of each peer: "
         "the fastest of ours whose normal is off by no more than the peer's, on the cases that "
         "the peer answers. Times are geometric means, errors means. A peer that tells a wrong "
         "depth is still taken by its normal, and its line is grey.</p><h3>Concave families</h3>" +
         ratiosTable(ofFamilies(chart["ratios"], false)) +
         "<h3>Convex families, against GJK and EPA on the hull of the same coarse mesh</h3><p>On "
         "spheres that hull has 642 vertices. Ours may err by 1\u00b0 here, whatever the hull "
         "errs.</p>" +
         ratiosTable(chart["hullRatios"]) +
         "<details><summary>Convex families, against all settings at the peer's own "
         "error</summary>" +
         ratiosTable(ofFamilies(chart["ratios"], true)) + "</details>";
}

std::string settingsText(const Json& chart) {
  std::string out = "<details><summary>How each method is set</summary><p>" +
                    textOf(chart, "metreScale") + "</p><div class=scroll><table class=wrapped>" +
                    row({"method", "setting", "how it is set", "scaled to 1 m"}, "th");
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
         " s. All methods ran in this one run; times were taken on one thread, nothing else of "
         "the run beside them.</small></p>";
}

std::string listOf(const Json& lines, const std::string& otherwise) {
  std::string out = "<ul>";
  for (const Json& line : lines) out += "<li>" + asHtml(line.get<std::string>()) + "</li>";
  if (lines.empty()) out += "<li>" + otherwise + "</li>";
  return out + "</ul>";
}

std::string pictureText(const ReportPictures& pictures) {
  return "<h2>Error against time</h2><p>Each mark is a method and a setting: its error is the "
         "mean over the cases, grids and depths of a family, its time the geometric mean over the "
         "cases. Left and low is good. Numbers beside ours are voxels to the body's size; peers "
         "that take meshes have a mark for each fineness of facets. A hollow mark leaves out "
         "cases that the method cannot do. A mark with a cross tells a wrong depth, off by more "
         "than half the body's size, or misses a touch: it is on no frontier and is not advised, "
         "however true its normal.</p>" +
         pictures.chart + "<p>The same for force and torque, where the truth is known.</p>" +
         pictures.force;
}

}  // namespace

std::string reportHtml(const Json& chart, const Json& failures, const ReportPictures& pictures) {
  const std::string title = chart.contains("subject")
                                ? "Contact of " + chart["subject"].get<std::string>()
                                : "Speed against accuracy, and who holds";
  std::string out =
      "<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport "
      "content=\"width=device-width\"><title>" +
      asHtml(title) + "</title><style>" + kStyle + "</style>\n<h1>" + asHtml(title) + "</h1>" +
      setupText(chart) + settingsText(chart);
  out += "<h2>Which method for which need</h2>" + listOf(chart["advice"], "nothing was run");
  out += "<h2>Where CloudContact falls short of its own aims</h2>" +
         listOf(chart["fallsShort"], "nowhere in what was run");
  out += ratiosText(chart) + pictureText(pictures);
  if (!pictures.failures.empty())
    out += "<h2>Stability where methods fail</h2>" + tally(failures) + kSolvers +
           pictures.failures + "<details><summary>All trials, with rules and limits</summary>" +
           failuresTable(failures) + "</details>";
  out += "<details><summary>All cases in figures</summary>" + chartTable(chart) + "</details>";
  out +=
      "<h2>Your own pair</h2><p><code>cloudcontact chart A.stl B.stl --pose \"x y z qx qy qz "
      "qw\" --out DIR</code> draws the same chart for two meshes of yours; the finest voxels "
      "stand for the truth, as nothing else is known of them.</p></html>\n";
  return out;
}

}  // namespace cloudcontact::program::lab
