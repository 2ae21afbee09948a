// Writes JSON first; the pictures and the report are made from it.
#include "lab/lab_results.h"

#include <LinearMath/btScalar.h>
#include <cloudcontact/version.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include "io/errors.h"
#include "io/json.h"
#include "io/output_file.h"
#include "lab/families.h"
#include "lab/peer_pairs.h"
#include "lab/ratios.h"
#include "lab/report.h"

namespace cloudcontact::program::embedded {
std::string_view plots_py();
}

namespace cloudcontact::program::lab {
namespace {

namespace fs = std::filesystem;

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "unknown";
}

Json spreadJson(const Spread& s) {
  return {{"mean", s.mean}, {"p95", s.p95}, {"max", s.max}};
}

Json versionsJson() {
  Json json = {{"cloudcontact", CLOUDCONTACT_VERSION},
               {"bullet", std::to_string(btGetVersion())},
               {"bulletPrecision", sizeof(btScalar) == 8 ? "double" : "float"},
               {"HACD", "of Bullet's extras " + std::to_string(btGetVersion())},
               {"compiler", __VERSION__}};
  for (const Version& version : peerVersions()) json[version.first] = version.second;
  return json;
}

Json methodsJson(const std::vector<LabMethod>& methods) {
  Json json = Json::array();
  for (const LabMethod& m : methods)
    json.push_back({{"method", m.method},
                    {"setting", m.setting},
                    {"told", m.description},
                    {"metreScale", m.meterScale}});
  return json;
}

Json rowJson(const ChartRow& r) {
  return {{"family", r.family},
          {"case", r.name},
          {"convex", r.convex},
          {"smooth", r.smooth},
          {"method", r.method},
          {"setting", r.setting},
          {"detail", r.detail},
          {"triangles", {r.triangles[0], r.triangles[1]}},
          {"vertices", {r.vertices[0], r.vertices[1]}},
          {"microseconds", r.microseconds},
          {"normalDeg", spreadJson(r.normalDeg)},
          {"depth", r.depth},
          {"depthTimes", r.depthTimes},
          {"wrongDepth", r.wrongDepth},
          {"centre", r.center},
          {"force", r.force},
          {"torque", r.torque},
          {"swappedNormalDeg", r.swapped.normalDeg},
          {"swappedForce", r.swapped.force},
          {"loopWork", r.loopWork},
          {"volume", r.volume},
          {"runs", r.runs},
          {"missed", r.missed},
          {"frontier", r.frontier},
          {"seconds", r.seconds},
          {"why", r.why}};
}

Json familyJson(const FamilyMark& m) {
  return {{"family", m.family},       {"method", m.method},
          {"setting", m.setting},     {"microseconds", m.microseconds},
          {"normalDeg", m.normalDeg}, {"wrench", m.wrench},
          {"cases", m.cases},         {"cannot", m.cannot},
          {"wrong", m.wrong},         {"depthTimes", m.depthTimes},
          {"frontier", m.frontier}};
}

Json ratiosJson(const std::vector<PeerRatio>& ratios) {
  Json json = Json::array();
  for (const PeerRatio& r : ratios)
    json.push_back({{"family", r.family},
                    {"convex", r.convex},
                    {"method", r.method},
                    {"setting", r.setting},
                    {"cases", r.cases},
                    {"of", r.of},
                    {"wrong", r.wrong},
                    {"microseconds", r.microseconds},
                    {"normalDeg", r.normalDeg},
                    {"allowedDeg", r.allowedDeg},
                    {"ours", r.ours},
                    {"oursMicroseconds", r.oursMicroseconds},
                    {"oursNormalDeg", r.oursNormalDeg},
                    {"timesFaster", r.timesFaster},
                    {"words", inWords(r)}});
  return json;
}

Json chartJson(const LabResults& results) {
  Json json;
  json["machine"] = {{"processor", processor()}, {"threads", std::thread::hardware_concurrency()}};
  json["versions"] = versionsJson();
  json["command"] = results.command;
  json["quick"] = results.quick;
  json["seconds"] = results.seconds;
  if (!results.subject.empty()) json["subject"] = results.subject;
  json["methods"] = methodsJson(results.methods);
  json["metreScale"] = whyMeterScale();
  json["wrongDepth"] = {{"share", kWrongDepth}, {"of", "size"}};
  json["rows"] = Json::array();
  for (const ChartRow& r : results.chart) json["rows"].push_back(rowJson(r));
  json["families"] = Json::array();
  for (const FamilyMark& m : familyMarks(results.chart)) json["families"].push_back(familyJson(m));
  json["ratios"] = ratiosJson(peerRatios(results.chart));
  json["hullRatios"] = ratiosJson(hullRatios(results.chart));
  json["advice"] = advice(results.chart);
  json["fallsShort"] = results.faults;
  return json;
}

const char* nameOf(Outcome outcome) {
  if (outcome == Outcome::Holds) return "holds";
  return outcome == Outcome::Fails ? "fails" : "cannot";
}

Json failuresJson(const LabResults& results) {
  Json json;
  json["rows"] = Json::array();
  for (const StabilityRow& r : results.stability)
    json["rows"].push_back({{"scene", r.scene},
                            {"group", r.group},
                            {"rule", r.rule},
                            {"method", std::string(program::nameOf(r.trial.method))},
                            {"step", r.trial.step},
                            {"mode", r.trial.mode},
                            {"outcome", nameOf(r.verdict.outcome)},
                            {"figure", r.verdict.figure},
                            {"limit", r.verdict.limit},
                            {"seconds", r.seconds},
                            {"timed", r.timed},
                            {"steps", r.cost.steps},
                            {"narrowPhaseMicroseconds", 1e6 * r.cost.narrowPhaseStep()},
                            {"stepMicroseconds", 1e6 * r.cost.wallStep()},
                            {"why", r.verdict.why}});
  return json;
}

// Runs a python with the embedded plots.py on its standard input. Returns whether it succeeded.
bool drawnBy(const char* python, const std::string& folder) {
  int script[2];
  if (pipe(script) != 0) return false;
  const pid_t child = fork();
  if (child == 0) {
    dup2(script[0], 0);
    close(script[0]);
    close(script[1]);
    // Its whole name: a python that is called "python3" takes the packages of the first in PATH.
    execlp(python, python, "-", folder.c_str(), nullptr);
    _exit(127);
  }
  close(script[0]);
  const auto before = std::signal(SIGPIPE, SIG_IGN);  // where it ends before it has read all
  const std::string_view text = embedded::plots_py();
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t count = write(script[1], text.data() + done, text.size() - done);
    if (count <= 0) break;
    done += static_cast<std::size_t>(count);
  }
  close(script[1]);
  std::signal(SIGPIPE, before);
  int status = 1;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

// The system's python first: matplotlib is among its packages, a python in PATH may lack it.
bool drawn(const std::string& folder) {
  return drawnBy("/usr/bin/python3", folder) || drawnBy("python3", folder);
}

std::string textOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace

bool makeFolder(const std::string& folder) {
  std::error_code error;
  const bool made = fs::create_directories(folder, error);
  if (!fs::is_directory(folder))
    throw BadInput("--out: " + folder +
                   " is not a folder and cannot be created; choose another folder");
  if (access(folder.c_str(), W_OK) != 0)
    throw BadInput("--out: " + folder + " cannot be written; choose another folder");
  return made;
}

std::string writeResults(const LabResults& results, const std::string& folder) {
  const fs::path place(folder);
  const auto write = [&](const char* name, const std::string& text) {
    writeWhole("--out", (place / name).string(), text);
  };
  const Json chart = chartJson(results), failures = failuresJson(results);
  write("chart.json", jsonText(chart) + "\n");
  write("failures.json", jsonText(failures) + "\n");
  if (!drawn(folder))
    throw WorkFailed(
        "chart: the pictures need python3 with matplotlib (script/bootstrap installs "
        "it); chart.json and failures.json are written");
  const auto picture = [&](const char* name) { return textOf(place / name); };
  const auto isTimed = [](const StabilityRow& r) { return r.timed && r.cost.steps > 0; };
  const bool timed = std::any_of(results.stability.begin(), results.stability.end(), isTimed);
  write("report.html", reportHtml(chart, failures,
                                  {picture("chart.svg"), picture("chart_force.svg"),
                                   results.stability.empty() ? "" : picture("failures.svg"),
                                   timed ? picture("running.svg") : ""}));
  std::string files = "report.html, chart.json, failures.json";
  if (!results.chart.empty()) files += ", chart.svg";
  if (!results.stability.empty()) files += ", failures.svg";
  if (timed) files += ", running.svg";
  return files;
}

}  // namespace cloudcontact::program::lab
