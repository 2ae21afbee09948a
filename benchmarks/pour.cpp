// Nuts poured into a box: a step's time, and how deep they stand in each other once they lie, on
// this project's clouds and on Bullet's convex parts (HACD) of the same nuts.
//   pour [--bodies N] [--seconds S] [--threads N] [--voxel H] [--limit S] [--out FILE.json]
// Depths are measured on the nut's triangles, by no method under test. A method that takes longer
// than the limit of wall time stops there, and the table says how far it came. Each runs in a
// process of its own: Bullet keeps an algorithm and a manifold for each two parts whose boxes meet,
// 6.7 GB for 200 nuts of 23 parts, and more than 24 in the first step of 1,000.
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

// How deep each pair that touches stands, sorted [m].
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
  double spent = 0;
  while (static_cast<int>(times.size()) < steps && spent < options.limit) {
    times.push_back(heap.step());
    spent += times.back();
  }
  const double ended = double(times.size()) / kSteps;
  const std::vector<double> deep = depths(heap, body);
  std::vector<double> last(times.end() - std::min<std::ptrdiff_t>(60, std::ssize(times)),
                           times.end());
  std::sort(last.begin(), last.end());
  double mean = 0;
  for (const double depth : deep) mean += depth / double(deep.size());
  std::printf(
      "%-10s %5.2f of %.2f s: step %8.2f ms on average, %8.2f at the end; fastest %7.1f mm/s; %zu "
      "pairs deep: mean %.4f, 95 of 100 %.4f, most %.4f mm\n",
      method.c_str(), ended, options.seconds, 1e3 * spent / double(times.size()),
      1e3 * at(last, 0.5), 1e3 * heap.fastest(), deep.size(), 1e3 * mean, 1e3 * at(deep, 0.95),
      1e3 * at(deep, 1));
  std::fflush(stdout);
  return {{"method", method},
          {"bodies", options.bodies},
          {"seconds", ended},
          {"stepSeconds", spent / double(times.size())},
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

// What a method comes to, in a process that the system ends first where memory runs out.
json apart(const char* method, const std::function<json()>& row) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe to another process");
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no other process");
  if (child == 0) {
    close(ends[0]);
    std::ofstream("/proc/self/oom_score_adj") << 1000;
    const std::string told = row().dump();
    std::size_t done = 0;
    while (done < told.size()) {
      const ssize_t some = write(ends[1], told.data() + done, told.size() - done);
      if (some <= 0) break;
      done += static_cast<std::size_t>(some);
    }
    _exit(0);
  }
  close(ends[1]);
  std::string told;
  char some[4096];
  for (ssize_t n; (n = read(ends[0], some, sizeof some)) > 0;)
    told.append(some, static_cast<std::size_t>(n));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFEXITED(status) && !told.empty()) return json::parse(told);
  if (!WIFSIGNALED(status) || WTERMSIG(status) != SIGKILL)
    throw std::runtime_error(std::string(method) + " failed");
  std::printf("%-10s was killed, as the system does where memory runs out\n", method);
  std::fflush(stdout);
  return {{"method", method}, {"killed", true}};
}

Options optionsOf(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; i += 2) {
    const std::string name = argv[i];
    if (i + 1 == argc) throw std::invalid_argument(name + ": a value is missing");
    const std::string value = argv[i + 1];
    if (name == "--bodies")
      options.bodies = std::stoi(value);
    else if (name == "--threads")
      options.threads = std::stoi(value);
    else if (name == "--seconds")
      options.seconds = std::stod(value);
    else if (name == "--voxel")
      options.voxel = std::stod(value);
    else if (name == "--limit")
      options.limit = std::stod(value);
    else if (name == "--out")
      options.out = value;
    else
      throw std::invalid_argument("'" + name +
                                  "' is not known; give --bodies, --seconds, --threads, --voxel, "
                                  "--limit or --out");
  }
  return options;
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
  if (!file) throw std::runtime_error(options.out + ": cannot be written");
}

}  // namespace

int main(int argc, char** argv) {
  try {
    measure(optionsOf(argc, argv));
    return 0;
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "pour: %s\n", failure.what());
    return 1;
  }
}
