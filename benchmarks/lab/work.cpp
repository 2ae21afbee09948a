// Runs short stretches of scenes, and a few queries of each family of the chart.
#include "lab/work.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <set>

#include "demos/demo.h"
#include "io/errors.h"
#include "lab/cases.h"
#include "lab/peer_pairs.h"
#include "scene/scene_clouds.h"
#include "scene/scene_file.h"

namespace cloudcontact::program::lab {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// Long enough to fall, meet and turn; a minute for all on one core.
constexpr int kSteps = 200;
constexpr double kGimpactSeconds = 3;  // of a scene; its steps are few where they are slow
constexpr int kParts = 32;             // voxels in a case's size
constexpr int kRepeat = 30;            // queries timed
constexpr double kJitter = 1e-3;       // shares of the size, between them

// A lookup reads seven numbers of a sample and an 8-byte record; a plane is a record, too. A hit is
// written and read with 16 numbers.
double bytesOf(const WorkCounts& work) {
  return double(work.samples) * 36 + double(work.planes) * 8 + double(work.hits) * 64;
}

// Reads so many bytes as a lookup does: columns in order, records in nearly that order.
double gatherSeconds(double bytes) {
  const auto count = static_cast<std::size_t>(bytes / 36) + 1;
  std::vector<std::uint64_t> records(count, 1);
  std::vector<float> columns[7];
  for (std::vector<float>& column : columns) column.assign(count, 1.0f);
  std::vector<std::uint32_t> where(count);
  std::uint32_t random = 1;
  for (std::size_t i = 0; i < count; ++i) {
    random = random * 1664525u + 1013904223u;
    where[i] = static_cast<std::uint32_t>(std::min(count - 1, i + (random >> 26)));
  }
  volatile std::uint64_t seen = 0;
  double best = 1e9;
  for (int turn = 0; turn < 20; ++turn) {
    const auto start = Clock::now();
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      float sample = 0;
      for (const std::vector<float>& column : columns) sample += column[i];
      sum += records[where[i]] + (sample > 0);
    }
    seen = seen + sum;
    best = std::min(best, std::chrono::duration<double>(Clock::now() - start).count());
  }
  return best;
}

// Runs the worlds of a scene or demo.
using Runs = std::function<void(const DemoStage::Shortened&)>;

WorkEntry entryOf(const std::string& name, const SimulationReport& report) {
  const auto each = [&](std::size_t sum) { return double(sum) / report.steps; };
  WorkEntry entry{name, {{"pairs", each(report.work.pairs)}}};
  for (const WorkCounts::Named& count : WorkCounts::all())
    entry.counts.emplace_back(count.name, each(report.work.contacts.*count.count));
  entry.counts.emplace_back("sweeps", each(report.work.sweeps));
  entry.counts.emplace_back("newton", each(report.work.newton));
  entry.counts.emplace_back("bytes", double(report.work.bytes));
  return entry;
}

WorkSource sourceOf(const std::string& name, int threads, const Runs& runs) {
  const auto named = [name](const std::string& label) {
    return label.empty() ? name : name + ", " + label;
  };
  const auto count = [=] {
    std::vector<WorkEntry> entries;
    runs({kSteps, 1e9, [&](WorldSettings& s) { s.common.threads = threads; },
          [&](const std::string& label, const SimulationReport& report) {
            entries.push_back(entryOf(named(label), report));
          }});
    return entries;
  };
  const auto time = [=](bool gimpact) {
    std::vector<WorkTime> times;
    runs({kSteps, 1e9, [&](WorldSettings& s) { s.common.threads = 1; },
          [&](const std::string& label, const SimulationReport& report) {
            const double steps = report.steps;
            times.push_back({named(label), report.narrowPhaseThreadSeconds / steps, 0,
                             gatherSeconds(bytesOf(report.work.contacts) / steps)});
          }});
    std::size_t next = 0;
    const auto asMeshes = [&](const std::string&, const SimulationReport& report) {
      times[next++].gimpact = report.narrowPhaseThreadSeconds / report.steps;
    };
    try {
      if (gimpact)
        runs({kSteps, kGimpactSeconds,
              [](WorldSettings& s) { s.common.method = Method::Gimpact, s.common.threads = 1; },
              asMeshes});
    } catch (const BadInput&) {  // bodies that are cut or deform
    }
    return times;
  };
  return {name, count, time};
}

WorkSource ofDemo(const Demo& demo, int threads) {
  return sourceOf(std::string("demo ") + demo.name, threads,
                  [run = demo.run](const DemoStage::Shortened& how) {
                    DemoStage stage(false);
                    stage.readRobot = robotOf;
                    stage.shorten(how);
                    run(stage);
                  });
}

// Options of scenes that need some.
CommonOptions optionsOf(const fs::path& file) {
  CommonOptions options;
  if (file.stem() == "milling") options.voxel = 5e-4;
  if (file.stem() == "tissue") {
    options.voxel = 1e-3;
    options.tissues.table = (file.parent_path() / "soft_tissues.json").string();
  }
  return options;
}

WorkSource ofScene(const fs::path& file, int threads) {
  return sourceOf(
      "scene " + file.stem().string(), threads, [file](const DemoStage::Shortened& how) {
        const SceneDescription scene = loadScene(file);
        WorldSettings settings;
        settings.common = optionsOf(file);
        settings.voxel = settings.common.voxel.value_or(defaultVoxel(scene, settings.common));
        how.adjust(settings);
        World world(scene, settings);
        SimulationSettings run;
        run.step = scene.step;
        how.done("", simulateShort(world, run, how.steps, how.seconds));
      });
}

// A case's bodies on one pair of grids.
struct Prepared {
  Instance instance;
  LabPair pair;

  Prepared(const LabCase& one, const LabMethod& method)
      : instance(one.make(1)),
        pair(method.prepare(instance.a, instance.b, method.detail * one.size)) {}
  // The mean of all placements.
  WorkCounts sum() const {
    WorkCounts sum;
    for (const Placement& placement : instance.placements) sum += pair.work(placement.b);
    return sum;
  }
  double microseconds(double size) const {
    double all = 0;
    for (const Placement& placement : instance.placements) {
      std::vector<double> times = pair.microseconds(placement.b, kRepeat, kJitter * size);
      std::nth_element(times.begin(), times.begin() + kRepeat / 2, times.end());
      all += times[kRepeat / 2];
    }
    return all / double(instance.placements.size());
  }
};

WorkSource ofPair(const LabCase& one, const LabMethod& method, const LabMethod& gimpact) {
  const std::string name = "pair " + one.family + " (" + method.method + ")";
  const auto count = [=] {
    const Prepared prepared(one, method);
    const WorkCounts sum = prepared.sum();
    WorkEntry entry{name, {}};
    for (const WorkCounts::Named& each : WorkCounts::all())
      entry.counts.emplace_back(
          each.name, double(sum.*each.count) / double(prepared.instance.placements.size()));
    return std::vector{entry};
  };
  const auto time = [=](bool peers) {
    const Prepared prepared(one, method);
    const double queries = double(prepared.instance.placements.size());
    WorkTime found{name, 1e-6 * prepared.microseconds(one.size), 0,
                   gatherSeconds(bytesOf(prepared.sum()) / queries)};
    try {
      if (peers) found.gimpact = 1e-6 * Prepared(one, gimpact).microseconds(one.size);
    } catch (const CannotDo&) {
    }
    return std::vector{found};
  };
  return {name, count, time};
}

// The method at this setting with kParts voxels or facets in a case's size.
LabMethod methodOf(const std::vector<LabMethod>& methods, const std::string& method,
                   const std::string& setting) {
  return *std::find_if(methods.begin(), methods.end(), [&](const LabMethod& one) {
    return one.method == method && one.setting.find(setting) != std::string::npos;
  });
}

void addPairs(std::vector<WorkSource>& sources) {
  const LabMethod cloud = methodOf(cloudMethods(), "cloud", "/ " + std::to_string(kParts)),
                  paper = methodOf(paperMethods(), "paper", "window 2.5"),
                  gimpact = methodOf(bulletMethods(), "gimpact", fraction(kFineFacets));
  std::set<std::string> families;
  for (const LabCase& one : allCases()) {
    if (!one.quick || !families.insert(one.family).second) continue;
    sources.push_back(ofPair(one, cloud, gimpact));
    if (one.family == "edges") sources.push_back(ofPair(one, paper, gimpact));
  }
}

}  // namespace

std::vector<WorkSource> workSources(const std::string& checkout, int threads) {
  std::vector<WorkSource> sources;
  for (const Demo& demo : demos())
    if (!demo.cuts) sources.push_back(ofDemo(demo, threads));
  const fs::path tests = fs::path(checkout) / "tests/program",
                 shared = fs::path(checkout) / "../shared/scenes";
  for (const char* name : {"milling.sdf", "tissue.sdf"})
    sources.push_back(ofScene(tests / name, threads));
  for (const char* name : {"chain.sdf", "cows.sdf", "nut_on_bolt.sdf", "peg_in_hole.sdf"})
    if (fs::exists(shared / name)) sources.push_back(ofScene(shared / name, threads));
  addPairs(sources);
  return sources;
}

}  // namespace cloudcontact::program::lab
