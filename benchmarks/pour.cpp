// Nuts poured into a box: time of a step, and penetration depths at rest, with this project's
// clouds and with Bullet's convex parts (HACD) of the same nuts.
//   pour [--bodies N] [--seconds S] [--threads N] [--voxel H] [--limit S] [--out FILE.json]
// Depths are measured on the nut's triangles, independently of the methods. A method stops at the
// limit of wall time, and the table shows how much it simulated. Each method runs in its own
// process, because convex parts may run out of memory: Bullet keeps an algorithm and a manifold for
// each pair of parts whose boxes overlap (docs/measurements.md).
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/voxels/digitize.h>

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "command.h"
#include "nuts.h"
#include "scene/penetration.h"

namespace {

using namespace cloudcontact;
using nlohmann::json;

constexpr double kSteps = 240;  // a second

struct Options {
  int bodies = 1000, threads = 1;
  double seconds = 2, voxel = 1e-3, limit = 120;
  std::string out;
};

HeapSettings pouredNuts(const Options& options) {
  HeapSettings settings = nutHeap(options.bodies, options.voxel, options.threads);
  settings.poured = true;
  return settings;
}

double at(const std::vector<double>& sorted, double share) {
  return sorted.empty() ? 0 : sorted[static_cast<std::size_t>(share * double(sorted.size() - 1))];
}

// Sorted penetration depths of the touching pairs [m].
std::vector<double> depths(Heap& heap, const program::MeasuredBody& body) {
  std::vector<double> found;
  for (const auto& [a, b] : heap.near()) {
    const double depth = program::penetration(body, heap.pose(a), body, heap.pose(b));
    if (depth > 0) found.push_back(depth);
  }
  std::sort(found.begin(), found.end());
  return found;
}

json run(const std::string& method, const Options& options, const HeapSettings& settings,
         const program::MeasuredBody& body) {
  Heap heap(settings);
  const int steps = static_cast<int>(std::lround(kSteps * options.seconds));
  std::vector<double> times;
  double total = 0;
  while (static_cast<int>(times.size()) < steps && total < options.limit) {
    times.push_back(heap.step());
    total += times.back();
  }
  const double ended = double(times.size()) / kSteps;
  const std::vector<double> deep = depths(heap, body);
  std::vector<double> last(times.end() - std::min<std::ptrdiff_t>(60, std::ssize(times)),
                           times.end());
  std::sort(last.begin(), last.end());
  double mean = 0;
  for (const double depth : deep) mean += depth / double(deep.size());
  std::printf(
      "%-10s simulated %5.2f of %.2f s: step %8.2f ms on average, %8.2f ms at the end; fastest "
      "point %7.1f mm/s; %zu pairs penetrate: mean %.4f, p95 %.4f, max %.4f mm\n",
      method.c_str(), ended, options.seconds, 1e3 * total / double(times.size()),
      1e3 * at(last, 0.5), 1e3 * heap.fastest(), deep.size(), 1e3 * mean, 1e3 * at(deep, 0.95),
      1e3 * at(deep, 1));
  std::fflush(stdout);
  return {{"method", method},
          {"bodies", options.bodies},
          {"seconds", ended},
          {"stepSeconds", total / double(times.size())},
          {"lastStepSeconds", at(last, 0.5)},
          {"fastest", heap.fastest()},
          {"deepPairs", deep.size()},
          {"depth", {{"mean", mean}, {"p95", at(deep, 0.95)}, {"max", at(deep, 1)}}}};
}

json cloudRow(const Options& options, const program::MeasuredBody& body) {
  DigitizeSettings how;
  how.voxelSize = options.voxel;
  const auto field = SurfaceField::build(digitize(nut(), how));
  HeapSettings settings = pouredNuts(options);
  settings.shape = [&] { return std::make_shared<CloudShape>(field); };
  return run("cloud", options, settings, body);
}

json partsRow(const Options& options, const program::MeasuredBody& body, double concavity) {
  const program::ConvexParts parts = program::convexParts(nut(), concavity);
  HeapSettings settings = pouredNuts(options);
  std::vector<std::shared_ptr<void>> keep;
  makeOfParts(settings, parts, keep);
  return run("hacd " + std::to_string(parts.corners.size()), options, settings, body);
}

// Runs a method in a process that the system kills first if memory runs out.
json apart(const char* method, const std::function<json()>& row) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("cannot make a pipe");
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("cannot start another process");
  if (child == 0) {
    close(ends[0]);
    std::ofstream("/proc/self/oom_score_adj") << 1000;
    const std::string text = row().dump();
    std::size_t done = 0;
    while (done < text.size()) {
      const ssize_t count = write(ends[1], text.data() + done, text.size() - done);
      if (count <= 0) break;
      done += static_cast<std::size_t>(count);
    }
    _exit(0);
  }
  close(ends[1]);
  std::string text;
  char buffer[4096];
  for (ssize_t n; (n = read(ends[0], buffer, sizeof buffer)) > 0;)
    text.append(buffer, static_cast<std::size_t>(n));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFEXITED(status) && !text.empty()) return json::parse(text);
  if (!WIFSIGNALED(status) || WTERMSIG(status) != SIGKILL)
    throw std::runtime_error(std::string(method) + " failed");
  std::printf("%-10s was killed, most likely because memory ran out\n", method);
  std::fflush(stdout);
  return {{"method", method}, {"killed", true}};
}

void measure(const Options& options) {
  const Mesh mesh = nut();
  const program::MeasuredBody body{{{program::probed(program::SceneMesh{}, &mesh), Pose{}}}};
  json rows;
  rows.push_back(apart("cloud", [&] { return cloudRow(options, body); }));
  for (const double concavity : {0.1, 0.01})
    rows.push_back(apart("hacd", [&] { return partsRow(options, body, concavity); }));
  if (options.out.empty()) return;
  std::ofstream file(options.out);
  file << json{{"rows", rows}, {"threads", options.threads}}.dump(2) << '\n';
  if (!file) throw std::runtime_error(options.out + ": cannot write the file");
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App words("Nuts poured into a box, beside convex parts", "pour");
  words.add_option("--bodies", options.bodies);
  words.add_option("--seconds", options.seconds);
  words.add_option("--threads", options.threads);
  words.add_option("--voxel", options.voxel, "[m]");
  words.add_option("--limit", options.limit, "[s] a method may take");
  words.add_option("--out", options.out, "a JSON file");
  return runCommand(words, argc, argv, [&options] { measure(options); });
}
