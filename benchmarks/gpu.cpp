// Time of the narrow phase of many pairs, transfers included, on an OpenCL device, on one core and
// on all cores. All give the same bits.
//   gpu [A.cloud B.cloud] [--pairs N] [--steps N] [--pose Z]
// B is at `0 0 Z` in A, with a small random offset in each pair and step. By default a threaded rod
// and ring. `cloudcontact digitize FILE --voxel H -o FILE.cloud` makes clouds from meshes. Each
// kernel is compared with a lower bound from the device's peak speeds, measured in the same run:
// copied bytes, random reads, additions and multiplications of doubles, transfers.
#include <cloudcontact/device/contact_batch.h>
#include <cloudcontact/voxels/cloud_file.h>
#include <cloudcontact/voxels/digitize.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <utility>

#include "device_speeds.h"
#include "kernels/contact/batch_layout.h"
#include "mesh/thread_meshes.h"
#include "timing.h"

namespace {

using namespace cloudcontact;

struct Arguments {
  std::vector<std::string> files;
  std::size_t pairs = 1024;
  int steps = 20;
  std::optional<double> pose;

  Arguments(int count, char** words) {
    for (int i = 1; i < count; ++i) {
      const std::string word = words[i];
      const bool more = i + 1 < count;
      if (word == "--pairs" && more)
        pairs = std::strtoul(words[++i], nullptr, 10);
      else if (word == "--steps" && more)
        steps = std::atoi(words[++i]);
      else if (word == "--pose" && more)
        pose = std::atof(words[++i]);
      else
        files.push_back(word);
    }
    if ((!files.empty() && files.size() != 2) || pairs == 0 || steps < 1)
      throw std::runtime_error("gpu [A.cloud B.cloud] [--pairs N] [--steps N] [--pose Z]");
    if (!pose) pose = files.empty() ? 0.0 : 0.0078;
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
    // A fifth of a voxel too tight.
    b = SurfaceField::build(digitize(threadedRing(thread, 13e-3, 12e-3, -5e-5), settings));
  }
};

// Random poses of a step, within a tenth of a voxel and a milliradian of the given one.
void pose(const Arguments& how, const Bodies& bodies, int step, std::vector<BatchPair>& pairs) {
  std::mt19937 random(static_cast<unsigned>(step));
  std::uniform_real_distribution<double> any(-1, 1);
  const double aside = 0.1 * bodies.a->cloud().voxelSize();
  pairs.resize(how.pairs);
  for (BatchPair& p : pairs) {
    p.a.field = bodies.a.get();
    p.b.field = bodies.b.get();
    p.b.pose.position = Vec3(0, 0, *how.pose) + aside * Vec3(any(random), any(random), any(random));
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

// Median time of a step [s]. The first two steps allocate memory and do not count.
double stepTime(ContactBatch& batch, const Arguments& how, const Bodies& bodies, int steps) {
  std::vector<BatchPair> pairs;
  std::vector<double> times;
  for (int step = -2; step < steps; ++step) {
    pose(how, bodies, step + 2, pairs);
    const double time = seconds([&] { batch.find(pairs); });
    if (step >= 0) times.push_back(time);
  }
  return median(times);
}

// The least work of a kernel: bytes read and written in sequence, 8-byte records read from random
// places, additions and multiplications of doubles.
struct Work {
  double bytes = 0, gathers = 0, doubles = 0;
};

Work leastWork(const std::string& name, const BatchReport& r) {
  const double samples = double(r.samples), hits = double(r.hits), bins = double(r.bins),
               patches = double(r.patches), contacts = double(r.contacts);
  constexpr double kHit = 64, kTried = 48, kKey = 8, kNumber = 4, kBin = sizeof(CcBin),
                   kSums = sizeof(CcSums), kSprout = sizeof(CcSprout),
                   kForce = sizeof(CcPatchForce), kContact = sizeof(CcContactPatch),
                   kPlaced = sizeof(CcPlaced), kPlace = 16, kLined = kPlace + sizeof(CcFacing);
  // Samples are read in sequence, their bricks and records at random. In this benchmark the
  // coarsest level finds enough hits, so the finer ones have no work.
  if (name == "ccSearch 2") return {samples * 32, 2 * samples, 0};
  if (name == "ccHits 2") return {hits * (32 + kHit + kKey), 2 * hits, 0};
  if (name == "ccBins") return {hits * (2 * kKey + 6 * kNumber) + bins * (48 + kBin), 0, 0};
  // 64 multiply-adds a hit, and 30 operations for its weight.
  if (name == "ccSums")
    return {hits * (kHit + kNumber) + bins * (kBin + kSums), 0, hits * (2 * 64 + 30)};
  if (name == "ccSprouts") return {bins * (2 * kSprout + kBin), 0, 0};
  if (name == "ccGrow") return {bins * (kSprout + kNumber), 0, 0};
  if (name == "ccPatches") return {bins * (kSums + kNumber) + patches * kSums, 0, bins * 150};
  // 1,500 operations; a division or root counts as 8.
  if (name == "ccForces") return {patches * (kSums + kForce), 0, patches * 1500};
  if (name == "ccLineUp") return {hits * (kTried + kNumber + kLined), hits, 0};
  // Each hit's place is read, by up to four places at 18 operations, and some 20 of a place's hits
  // are tried at 60. In the last rounds most patches have no place that moved.
  if (name == "ccNearest 0")
    return {hits * kPlace + contacts * kPlaced / 5, 0, hits * 18 + contacts * 20 * 60};
  if (name == "ccNearest 1")
    return {hits * kPlace + contacts * kPlaced, 0, 4 * (hits * 2 * 18 + contacts * 2 * 20 * 60)};
  if (name == "ccPlans") return {contacts * (kSums + kForce + kPlaced), 0, contacts * 1000};
  if (name == "ccContacts")
    return {contacts * (kSums + kForce + kPlaced + kContact), 0, contacts * 1500};
  if (name == "ccLevels") return {2 * contacts * kContact, 0, 0};
  return {};
}

// The largest lower bound of a kernel's time [s], and the speed that sets it.
std::pair<double, const char*> boundOf(const Work& work, const DeviceSpeeds& speeds) {
  const std::pair<double, const char*> bounds[] = {{work.bytes / speeds.copy, "copy"},
                                                   {work.gathers / speeds.gather, "gather"},
                                                   {work.doubles / speeds.doubles, "doubles"}};
  return *std::max_element(std::begin(bounds), std::end(bounds));
}

void printKernels(const Arguments& how, const Bodies& bodies, const DeviceSpeeds& speeds) {
  BatchSettings settings{Backend::OpenCl, 0, true};
  ContactBatch batch(settings);
  stepTime(batch, how, bodies, 1);
  batch.deviceTimes();
  stepTime(batch, how, bodies, how.steps);
  const BatchReport& r = batch.report();
  std::printf(
      "one step: %zu samples looked up, %zu hits, %zu bins, %zu patches, %zu contacts; %zu pairs "
      "on "
      "the device, %zu on the CPU; %.3f MB uploaded, %.3f MB downloaded; %.1f MB of device "
      "memory\n",
      r.samples, r.hits, r.bins, r.patches, r.contacts, r.onDevice, r.onCpu, 1e-6 * double(r.sent),
      1e-6 * double(r.fetched), 1e-6 * double(batch.deviceBytes()));
  std::printf("%-18s %10s %10s %8s  %s\n", "on the device", "us a step", "bound us", "of peak",
              "speed");
  double all = 0;
  for (const auto& [name, time] : batch.deviceTimes()) {
    const double each = time.seconds / (how.steps + 2);
    auto [bound, speed] = boundOf(leastWork(name, r), speeds);
    if (name == "poses sent") bound = double(r.sent) / speeds.upload, speed = "upload";
    if (name == "contacts fetched") bound = double(r.fetched) / speeds.download, speed = "download";
    all += each;
    std::printf("%-18s %10.1f %10.1f %7.1f%%  %s\n", name.c_str(), 1e6 * each, 1e6 * bound,
                100 * bound / each, bound > 0 ? speed : "-");
  }
  std::printf("%-18s %10.1f\n", "total", 1e6 * all);
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
  for (int round = 0; round < 2; ++round) {  // in the second round all pairs fit
    const auto got = device.find(pairs), want = cores.find(pairs);
    for (std::size_t k = 0; k < pairs.size(); ++k) unequal += !same(*got[k], *want[k]);
  }
  std::printf("%zu pairs: %zu differ from the CPU\n", pairs.size(), unequal);
  const double gpu = stepTime(device, how, bodies, how.steps);
  const double all = stepTime(cores, how, bodies, std::min(how.steps, 5));
  const double single = stepTime(one, how, bodies, std::min(how.steps, 3));
  std::printf(
      "median step of %zu pairs: OpenCL %.3f ms (%.2f us a pair), %u cores %.3f ms (%.1f times as "
      "long), one core %.3f ms (%.1f times as long)\n",
      pairs.size(), 1e3 * gpu, 1e6 * gpu / double(pairs.size()),
      std::thread::hardware_concurrency(), 1e3 * all, all / gpu, 1e3 * single, single / gpu);
  printKernels(how, bodies, speeds);
  if (unequal > 0) throw std::runtime_error("the contacts of the device and the CPU differ");
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
