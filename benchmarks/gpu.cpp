// The narrow phase of many pairs in one step, transfers included, on an OpenCL device, on one core
// and on all of them, with the same bits:
//   gpu [A.cloud B.cloud] [--pairs N] [--steps N] [--pose Z]
// B stands at `0 0 Z` in A, each pair a little elsewhere, and in every step elsewhere again.
// Without files: a rod and a ring with one thread. `cloudcontact digitize FILE --voxel H -o
// FILE.cloud` makes clouds of meshes. Each step on the device is told beside the least time that
// the device's ceilings, measured in the same run, leave it: a copy's bytes, records gathered from
// anywhere, sums and products of doubles, transfers.
#include <cloudcontact/device/contact_batch.h>
#include <cloudcontact/voxels/cloud_file.h>
#include <cloudcontact/voxels/digitize.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <random>
#include <string>
#include <thread>
#include <utility>

#include "device/device_probe.h"
#include "mesh/thread_meshes.h"

namespace {

using namespace cloudcontact;
using Clock = std::chrono::steady_clock;

struct Arguments {
  std::vector<std::string> files;
  std::size_t pairs = 1024;
  int steps = 20;
  double pose = 0;
  bool posed = false;

  Arguments(int count, char** words) {
    for (int i = 1; i < count; ++i) {
      const std::string word = words[i];
      const bool more = i + 1 < count;
      if (word == "--pairs" && more)
        pairs = std::strtoul(words[++i], nullptr, 10);
      else if (word == "--steps" && more)
        steps = std::atoi(words[++i]);
      else if (word == "--pose" && more)
        pose = std::atof(words[++i]), posed = true;
      else
        files.push_back(word);
    }
    if ((!files.empty() && files.size() != 2) || pairs == 0 || steps < 1)
      throw std::runtime_error("gpu [A.cloud B.cloud] [--pairs N] [--steps N] [--pose Z]");
    if (!posed) pose = files.empty() ? 0.0 : 0.0078;
  }
};

struct Bodies {
  std::shared_ptr<const SurfaceField> a, b;

  explicit Bodies(const std::vector<std::string>& files) {
    if (!files.empty()) {
      a = SurfaceField::build(loadCloud(files[0]));
      b = SurfaceField::build(loadCloud(files[1]));
      return;
    }
    const Thread thread;
    DigitizeSettings settings;
    settings.voxelSize = 2.5e-4;
    a = SurfaceField::build(digitize(threadedRod(thread, 24e-3), settings));
    // Pressed by a fifth of a voxel all around.
    b = SurfaceField::build(digitize(threadedRing(thread, 13e-3, 12e-3, -5e-5), settings));
  }
};

// Poses of a step: up to a tenth of a voxel and a milliradian from the named one.
void pose(const Arguments& how, const Bodies& bodies, int step, std::vector<BatchPair>& pairs) {
  std::mt19937 random(static_cast<unsigned>(step));
  std::uniform_real_distribution<double> any(-1, 1);
  const double aside = 0.1 * bodies.a->cloud().voxelSize();
  pairs.resize(how.pairs);
  for (BatchPair& p : pairs) {
    p.a.field = bodies.a.get();
    p.b.field = bodies.b.get();
    p.b.pose.position = Vec3(0, 0, how.pose) + aside * Vec3(any(random), any(random), any(random));
    p.b.pose.orientation =
        Eigen::Quaterniond(1, 5e-4 * any(random), 5e-4 * any(random), 5e-4 * any(random))
            .normalized();
  }
}

bool same(const ContactResult& a, const ContactResult& b) {
  const auto equal = [](double x, double y) { return std::memcmp(&x, &y, sizeof x) == 0; };
  bool all = a.points.size() == b.points.size() && a.samples == b.samples;
  for (std::size_t i = 0; all && i < a.points.size(); ++i) {
    const ContactPoint &p = a.points[i], &q = b.points[i];
    for (int k = 0; k < 3; ++k)
      all = all && equal(p.position[k], q.position[k]) && equal(p.normal[k], q.normal[k]);
    all = all && equal(p.depth, q.depth) && equal(p.stiffness, q.stiffness) && p.id == q.id;
  }
  return all;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

// Seconds of each step; the first two make room and are not counted.
double timed(ContactBatch& batch, const Arguments& how, const Bodies& bodies, int steps) {
  std::vector<BatchPair> pairs;
  std::vector<double> seconds;
  for (int step = -2; step < steps; ++step) {
    pose(how, bodies, step + 2, pairs);
    const auto begin = Clock::now();
    batch.find(pairs);
    if (step >= 0) seconds.push_back(std::chrono::duration<double>(Clock::now() - begin).count());
  }
  return median(seconds);
}

// What a step on the device must do at least: bytes that it reads and writes in turn, 8-byte
// records that it fetches from anywhere, sums and products of doubles.
struct Need {
  double bytes = 0, gathers = 0, doubles = 0;
};

Need needOf(const std::string& name, const BatchReport& r) {
  const double asked = double(r.asked), hits = double(r.hits), bins = double(r.bins),
               patches = double(r.patches), contacts = double(r.contacts);
  constexpr double kHit = 64, kKey = 8, kNumber = 4, kBin = 32, kSums = 632, kSprout = 120,
                   kForce = 104, kContact = 368;
  // A sample is read in turn; the brick and the record that it falls in are not. Here the coarsest
  // level finds enough; the finer ones have nothing to do.
  if (name == "ccSearch 2") return {asked * 32, 2 * asked, 0};
  if (name == "ccHits 2") return {hits * (32 + kHit + kKey), 2 * hits, 0};
  if (name == "ccBins") return {hits * (2 * kKey + 6 * kNumber) + bins * (48 + kBin), 0, 0};
  // 64 sums of products, and 30 to weigh a hit.
  if (name == "ccSums")
    return {hits * (kHit + kNumber) + bins * (kBin + kSums), 0, hits * (2 * 64 + 30)};
  if (name == "ccSprouts") return {bins * (2 * kSprout + kBin), 0, 0};
  if (name == "ccGrow") return {bins * (kSprout + kNumber), 0, 0};
  if (name == "ccPatches") return {bins * (kSums + kNumber) + patches * kSums, 0, bins * 150};
  // 1,500 sums and products, divisions and roots counted as 8 of them.
  if (name == "ccContacts")
    return {patches * (kSums + 2 * kForce) + contacts * (kSums + kContact), 0, patches * 1500};
  return {};
}

// The most that a ceiling asks for a step [s], and which.
std::pair<double, const char*> floorOf(const Need& need, const DeviceSpeeds& speeds) {
  const std::pair<double, const char*> floors[] = {{need.bytes / speeds.copy, "copy"},
                                                   {need.gathers / speeds.gather, "gather"},
                                                   {need.doubles / speeds.doubles, "doubles"}};
  return *std::max_element(std::begin(floors), std::end(floors));
}

void tellSteps(const Arguments& how, const Bodies& bodies, const DeviceSpeeds& speeds) {
  BatchSettings settings{Backend::OpenCl, 0, true};
  ContactBatch batch(settings);
  timed(batch, how, bodies, 1);
  batch.deviceTimes();
  timed(batch, how, bodies, how.steps);
  const BatchReport& r = batch.report();
  std::printf(
      "a step: %zu samples asked, %zu hits, %zu bins, %zu patches, %zu of them contacts; %zu pairs "
      "on the device, "
      "%zu on the CPU; %.3f MB sent, %.3f MB fetched; %.1f MB on the device\n",
      r.asked, r.hits, r.bins, r.patches, r.contacts, r.onDevice, r.onCpu, 1e-6 * double(r.sent),
      1e-6 * double(r.fetched), 1e-6 * double(batch.deviceBytes()));
  std::printf("%-18s %10s %10s %8s  %s\n", "on the device", "us a step", "floor us", "share",
              "of the ceiling");
  double all = 0;
  for (const auto& [name, time] : batch.deviceTimes()) {
    const double each = time.seconds / (how.steps + 2);
    auto [floor, ceiling] = floorOf(needOf(name, r), speeds);
    if (name == "poses sent") floor = double(r.sent) / speeds.upload, ceiling = "upload";
    if (name == "contacts fetched")
      floor = double(r.fetched) / speeds.download, ceiling = "download";
    all += each;
    std::printf("%-18s %10.1f %10.1f %7.1f%%  %s\n", name.c_str(), 1e6 * each, 1e6 * floor,
                100 * floor / each, floor > 0 ? ceiling : "-");
  }
  std::printf("%-18s %10.1f\n", "together", 1e6 * all);
}

void run(const Arguments& how) {
  const DeviceSpeeds speeds = measureDevice();
  std::printf(
      "%s: copy %.1f GB/s, gather %.2f G/s of 8 bytes, doubles %.0f G/s, upload %.1f GB/s, "
      "download %.1f GB/s, launch %.1f us\n",
      speeds.device.c_str(), 1e-9 * speeds.copy, 1e-9 * speeds.gather, 1e-9 * speeds.doubles,
      1e-9 * speeds.upload, 1e-9 * speeds.download, 1e6 * speeds.launch);
  const Bodies bodies(how.files);
  ContactBatch device({Backend::OpenCl, 0, false}), one({Backend::Cpu, 1, false}),
      cores({Backend::Cpu, 0, false});
  if (device.backend() != Backend::OpenCl) throw std::runtime_error(device.message());
  std::vector<BatchPair> pairs;
  pose(how, bodies, 99, pairs);
  std::size_t unequal = 0;
  for (int round = 0; round < 2; ++round) {  // the second finds the room that the first asked for
    const auto got = device.find(pairs), want = cores.find(pairs);
    for (std::size_t k = 0; k < pairs.size(); ++k) unequal += !same(*got[k], *want[k]);
  }
  std::printf("%zu pairs: %zu unlike the CPU's, to the bit\n", pairs.size(), unequal);
  const double gpu = timed(device, how, bodies, how.steps);
  const double all = timed(cores, how, bodies, std::min(how.steps, 5));
  const double single = timed(one, how, bodies, std::min(how.steps, 3));
  std::printf(
      "a step of %zu pairs, median: OpenCL %.3f ms (%.2f us a pair), %u cores %.3f ms "
      "(%.1f times that), one core %.3f ms (%.1f times)\n",
      pairs.size(), 1e3 * gpu, 1e6 * gpu / double(pairs.size()),
      std::thread::hardware_concurrency(), 1e3 * all, all / gpu, 1e3 * single, single / gpu);
  tellSteps(how, bodies, speeds);
  if (unequal > 0) throw std::runtime_error("the device's contacts are not the CPU's");
}

}  // namespace

int main(int count, char** words) {
  try {
    run(Arguments(count, words));
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "gpu: %s\n", e.what());
    return 1;
  }
}
