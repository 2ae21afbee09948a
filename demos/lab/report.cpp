// HTML put together from JSON: words, pictures, tables.
#include "lab/report.h"

#include <cmath>
#include <cstdio>
#include <map>

#include "html.h"

namespace cloudcontact::program::lab {
namespace {

constexpr const char* kStyle =
    "body{font:15px/1.5 system-ui,'DejaVu Sans',sans-serif;margin:0 auto;max-width:1180px;"
    "padding:1rem;color:#20242c}svg{max-width:100%;height:auto}table{border-collapse:collapse;"
    "font-size:13px;margin:.5rem 0}td,th{padding:.15rem .6rem;border-bottom:1px solid #dfe2e7;"
    "text-align:right;white-space:nowrap}td:nth-child(-n+3),th:nth-child(-n+3){text-align:left}"
    ".holds{color:#2d7a4f}.fails{color:#b3273b;font-weight:600}.cannot{color:#777}"
    "code{background:#eef0f3;padding:.1rem .3rem}details{margin:.4rem 0}.scroll{overflow-x:auto}"
    "small{color:#666}";

// A figure of a table: three digits, a dash where nothing is known.
std::string cell(const Json& value, double factor = 1) {
  if (!value.is_number()) return "\u2013";
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

std::string chartTable(const Json& chart) {
  std::string out = "<div class=scroll><table>" +
                    row({"case", "method", "setting", "\u00b5s", "normal mean \u00b0", "p95 \u00b0",
                         "max \u00b0", "depth \u00b5m", "centre \u00b5m", "force %", "torque %"},
                        "th");
  for (const Json& r : chart["rows"]) {
    const std::string name = asHtml(r["case"].get<std::string>());
    const std::string method = asHtml(r["method"].get<std::string>());
    const std::string setting = asHtml(r["setting"].get<std::string>());
    const std::string why = r["why"].get<std::string>();
    if (!why.empty()) {
      out += "<tr class=cannot><td>" + name + "</td><td>" + method + "</td><td>" + setting +
             "</td><td colspan=8 style=\"text-align:left;white-space:normal\">" + asHtml(why) +
             "</td></tr>\n";
      continue;
    }
    out += row({name, method, setting, cell(r["microseconds"]), cell(r["normalDeg"]["mean"]),
                cell(r["normalDeg"]["p95"]), cell(r["normalDeg"]["max"]), cell(r["depth"], 1e6),
                cell(r["centre"], 1e6), cell(r["force"], 100), cell(r["torque"], 100)});
  }
  return out + "</table></div>";
}

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

std::string setupText(const Json& chart) {
  const Json& m = chart["machine"];
  const Json& v = chart["versions"];
  return "<p><small>" + asHtml(m["processor"].get<std::string>()) + ", " +
         std::to_string(m["threads"].get<int>()) + " threads; CloudContact " +
         asHtml(v["cloudcontact"].get<std::string>()) + ", Bullet " +
         asHtml(v["bullet"].get<std::string>()) + " (" +
         asHtml(v["bulletPrecision"].get<std::string>()) + "), GCC " +
         asHtml(v["compiler"].get<std::string>()) + "; <code>" +
         asHtml(chart["command"].get<std::string>()) + "</code>, " + cell(chart["seconds"]) +
         " s. All methods ran in this one run, the times on one thread.</small></p>";
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
      setupText(chart);
  out += "<h2>Which method for which need</h2><ul>";
  for (const Json& line : chart["advice"])
    out += "<li>" + asHtml(line.get<std::string>()) + "</li>";
  out += "</ul><h2>Where CloudContact falls short of its own aims</h2><ul>";
  for (const Json& line : chart["fallsShort"])
    out += "<li>" + asHtml(line.get<std::string>()) + "</li>";
  if (chart["fallsShort"].empty()) out += "<li>nowhere in what was run</li>";
  out +=
      "</ul><h2>Error against time</h2><p>Each mark is a method and a setting, its error the "
      "mean over the cases, grids and depths of a family; numbers beside ours are voxels to the "
      "body's size. Left and low is good.</p>" +
      pictures.chart + "<p>The same for force and torque, where the truth is known.</p>" +
      pictures.force;
  if (!pictures.failures.empty())
    out += "<h2>Stability where methods fail</h2>" + tally(failures) + pictures.failures +
           "<details><summary>All trials, with rules and limits</summary>" +
           failuresTable(failures) + "</details>";
  out += "<details><summary>All cases in figures</summary>" + chartTable(chart) + "</details>";
  out +=
      "<h2>Your own pair</h2><p><code>cloudcontact chart A.stl B.stl --pose \"x y z qx qy qz "
      "qw\" --out DIR</code> draws the same chart for two meshes of yours; the finest voxels "
      "stand for the truth, as nothing else is known of them.</p></html>\n";
  return out;
}

}  // namespace cloudcontact::program::lab
