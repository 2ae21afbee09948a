// Time to cut voxels from a workpiece on an OpenCL device, compared with one core. Both leave the
// same bits.
//   gpu_cut [--radius R] [--turns N]
// The workpiece is a ball of radius R voxels (79.4: 2.1 million voxels). Each turn removes part of
// 1,000 or 100,000 voxels, adjacent or scattered, or the voxels in a moving ball. Each kernel is
// compared with the bytes it must move: it reads and writes the sums of all voxels whose windows
// see the cut.
#include <cloudcontact/device/device_workpiece.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/grid_index.h"
#include "device_speeds.h"
#include "field/base_vector_bricks.h"
#include "timing.h"

namespace {

using namespace cloudcontact;

constexpr double kVoxel = 1e-4;  // [m]
const TissueTable kTissue{{"bone", 2e4, .4, 3e9, 1900}};
constexpr double kInner = 0.55;  // edge of a box inside the ball, of the ball's diameter
constexpr int kRepeats = 12;     // cuts of the same voxel, by 20/255 each

Cloud ballCloud(double radius) {
  auto v = std::make_shared<Cloud::Voxels>();
  const int bricks = static_cast<int>(std::ceil((2 * radius + 2) / kBrickEdge));
  v->bricks = Eigen::Vector3i::Constant(bricks);
  const Vec3 center = Vec3::Constant(0.5 * kBrickEdge * bricks);
  for (int e = 0; e < v->bricks.prod(); ++e) {
    const Eigen::Vector3i low = kBrickEdge * gridCell(static_cast<std::size_t>(e), v->bricks);
    BrickCoverage brick;
    int least = 255, most = 0;
    for (int k = 0; k < kBrickVoxels; ++k) {
      const Vec3 at = (low + cellOffset(k)).cast<double>();
      const double in = radius - (at + Vec3::Constant(0.5) - center).norm() + 0.5;
      const int c = static_cast<int>(255 * std::clamp(in, 0.0, 1.0));
      brick[static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(c);
      least = std::min(least, c), most = std::max(most, c);
    }
    v->table.push_back(least == 255 ? kSolidBrick
                       : most == 0  ? kEmptyBrick
                                    : static_cast<std::int32_t>(v->coverage.size()));
    if (v->table.back() >= 0) v->coverage.push_back(brick);
  }
  return Cloud(kVoxel, Vec3::Zero(), std::move(v));
}

using Steps = std::vector<std::vector<VoxelCut>>;

// A voxel's coverage after some cuts.
std::uint8_t coverageAfter(std::size_t cuts) {
  return static_cast<std::uint8_t>(240 - 20 * (cuts % kRepeats));
}

// Adjacent boxes around the ball's center, cut in turn, by a part each time.
Steps adjacent(const BaseVectorField& field, const Eigen::Vector3i& box, int turns) {
  const Eigen::Vector3i size = field.size(), n = (kInner * size.cast<double>()).cast<int>();
  std::vector<Eigen::Vector3i> corners;
  const Eigen::Vector3i first = (size - n) / 2;
  for (int z = 0; z + box.z() <= n.z(); z += box.z())
    for (int y = 0; y + box.y() <= n.y(); y += box.y())
      for (int x = 0; x + box.x() <= n.x(); x += box.x())
        corners.push_back(first + Eigen::Vector3i(x, y, z));
  Steps steps(static_cast<std::size_t>(turns));
  for (std::size_t t = 0; t < steps.size(); ++t)
    for (int k = 0; k < box.prod(); ++k)
      steps[t].push_back({corners[t % corners.size()] + gridCell(static_cast<std::size_t>(k), box),
                          coverageAfter(t / corners.size())});
  return steps;
}

// Cuts every full voxel a little, so that no two bricks share a block.
std::vector<VoxelCut> shallowCut(const BaseVectorField& field) {
  std::vector<VoxelCut> all;
  const Eigen::Vector3i n = field.size();
  for (int k = 0; k < n.prod(); ++k) {
    const VoxelIndex v = gridCell(static_cast<std::size_t>(k), n);
    if (field.coverage(v) == 255) all.push_back({v, 254});
  }
  return all;
}

// Random voxels, some of them twice.
Steps scattered(const BaseVectorField& field, int count, int turns) {
  std::mt19937 random(3);
  const std::vector<VoxelCut> all = shallowCut(field);
  std::uniform_int_distribution<std::size_t> which(0, all.size() - 1);
  std::vector<std::uint8_t> cuts(all.size());
  Steps steps(static_cast<std::size_t>(turns));
  for (auto& step : steps)
    for (int k = 0; k < count; ++k) {
      const std::size_t i = which(random);
      step.push_back({all[i].voxel, coverageAfter(cuts[i]++)});
    }
  return steps;
}

// Median time of a turn [s]. The first two turns allocate memory and do not count.
template <typename Piece>
double turnTime(Piece& piece, const Steps& steps, std::vector<std::size_t>& changed) {
  std::vector<double> times;
  changed.clear();
  for (const auto& step : steps)
    times.push_back(seconds([&] { changed.push_back(piece.cut(step)); }));
  times.erase(times.begin(), times.begin() + 2);
  return median(times);
}

bool same(const BaseVectorField& a, const BaseVectorField& b) {
  const BaseVectorField::Bricks &p = a.bricks(), &q = b.bricks();
  for (std::size_t e = 0; e < p.table.size(); ++e) {
    if ((p.table[e] == kNoBlock) != (q.table[e] == kNoBlock)) return false;
    if (p.table[e] != kNoBlock &&
        std::memcmp(&p.blocks[std::size_t(p.table[e])], &q.blocks[std::size_t(q.table[e])],
                    sizeof(FieldBlock)) != 0)
      return false;
  }
  return a.hash() == b.hash() && a.mass().inertia == b.mass().inertia;
}

// Number of voxels with material nearby whose windows see a voxel of a step.
std::size_t voxelsSeeing(const BaseVectorField& field, const std::vector<VoxelCut>& step) {
  const Eigen::Vector3i n = field.size();
  std::vector<bool> seen(static_cast<std::size_t>(n.prod()));
  std::size_t count = 0;
  for (const VoxelCut& c : step)
    for (const WindowTap& t : field.window().taps) {
      const VoxelIndex v = c.voxel - VoxelIndex(t.x, t.y, t.z);
      if (!field.bricks().blockOf(v)) continue;
      const std::size_t at = gridIndex(v, n);
      count += !seen[at];
      seen[at] = true;
    }
  return count;
}

void printKernels(const BaseVectorField& whole, const Steps& steps, const DeviceSpeeds& speeds) {
  const auto copy = [&] {
    return BaseVectorField(std::make_unique<BaseVectorField::Bricks>(whole.bricks()));
  };
  DeviceWorkpiece piece(copy(), {Backend::OpenCl, true});
  piece.cut(shallowCut(whole));
  for (std::size_t t = 0; t < 2; ++t) piece.cut(steps[t]);
  piece.deviceTimes();
  for (std::size_t t = 2; t < steps.size(); ++t) piece.cut(steps[t]);
  const double turns = static_cast<double>(steps.size() - 2);
  const DeviceCutReport r = piece.report();
  const double listed = double(r.voxels), seeing = double(voxelsSeeing(whole, steps.back()));
  std::printf("  windows of %zu bricks and %.0f voxels see the cut; %.3f MB uploaded\n", r.bricks,
              seeing, 1e-6 * double(r.sent));
  double all = 0;
  for (const auto& [name, time] : piece.deviceTimes()) {
    const double each = time.seconds / turns;
    all += each;
    // A listed voxel, its coverage and link; its tissue and loss; sums of 40 bytes.
    const double bytes = name == "ccStringCuts"     ? listed * (8 + 1 + 4 + 4)
                         : name == "ccNoteLosses"   ? listed * (8 + 4 + 4 + 2 + 2)
                         : name == "ccRenewWindows" ? seeing * 2 * 40 + listed * 2 * 2
                         : name == "step sent"      ? double(r.sent)
                                                    : 0;
    std::printf("  %-16s %8.1f us, must move %7.3f MB: %5.1f%% of copy speed\n", name.c_str(),
                1e6 * each, 1e-6 * bytes, 100 * bytes / each / speeds.copy);
  }
  std::printf("  %-16s %8.1f us\n", "total", 1e6 * all);
}

bool compare(const char* name, const BaseVectorField& whole, const Steps& steps,
             const DeviceSpeeds& speeds) {
  const auto copy = [&] {
    return BaseVectorField(std::make_unique<BaseVectorField::Bricks>(whole.bricks()));
  };
  BaseVectorField cpu = copy();
  DeviceWorkpiece device(copy(), {Backend::OpenCl});
  if (device.backend() != Backend::OpenCl) throw std::runtime_error(device.message());
  std::vector<std::size_t> onCpu, onDevice;
  const std::vector<VoxelCut> first = shallowCut(whole);
  if (cpu.cut(first) != device.cut(first)) return false;
  const double one = turnTime(cpu, steps, onCpu), gpu = turnTime(device, steps, onDevice);
  const bool equal =
      onCpu == onDevice && same(device.field(), cpu) && device.mass().inertia == cpu.mass().inertia;
  std::printf("%-16s %6zu voxels a turn: CPU %.3f ms, device %.3f ms, %.1f times faster; %s\n",
              name, steps[0].size(), 1e3 * one, 1e3 * gpu, one / gpu,
              equal ? "same bits" : "DIFFERENT");
  printKernels(whole, steps, speeds);
  return equal;
}

// A ball moves through the workpiece; in each turn half of it meets new material. Only its pose is
// sent to the device.
bool comparePasses(const BaseVectorField& whole, int turns) {
  const auto copy = [&] {
    return BaseVectorField(std::make_unique<BaseVectorField::Bricks>(whole.bricks()));
  };
  const double width = kVoxel * whole.size().x(), radius = 0.16 * width;
  const PlacedSolid ball{Sphere{radius}};
  BaseVectorField cpu = copy();
  DeviceWorkpiece device(copy(), {Backend::OpenCl});
  const std::vector<VoxelCut> first = shallowCut(whole);
  if (cpu.cut(first) != device.cut(first)) return false;
  std::vector<double> onCpu, onDevice;
  std::size_t changed = 0, least = ~std::size_t{0}, most = 0;
  bool equal = true;
  for (int t = 0; t < turns; ++t) {
    Pose pose;
    const double angle = 0.6 * t, far = 0.3 * width * std::sqrt((t + 0.5) / turns);
    pose.position = Vec3::Constant(0.5 * width) +
                    far * Vec3(std::cos(angle), std::sin(angle), 0.7 * std::cos(2.3 * angle));
    onCpu.push_back(seconds([&] { changed = cpu.cut(cutsOf(cpu, ball, pose)); }));
    onDevice.push_back(seconds([&] { equal = device.cut(ball, pose) == changed && equal; }));
    least = std::min(least, changed), most = std::max(most, changed);
  }
  equal = equal && same(device.field(), cpu);
  std::printf(
      "moving ball, %zu to %zu voxels a turn: CPU %.3f ms, device %.3f ms, %.1f times faster; %s\n",
      least, most, 1e3 * median(onCpu), 1e3 * median(onDevice), median(onCpu) / median(onDevice),
      equal ? "same bits" : "DIFFERENT");
  return equal;
}

void run(double radius, int turns) {
  const DeviceSpeeds speeds = measureDevice();
  std::printf("%s: copy %.1f GB/s, upload %.1f GB/s, launch %.1f us\n", speeds.device.c_str(),
              1e-9 * speeds.copy, 1e-9 * speeds.upload, 1e6 * speeds.launch);
  const Cloud cloud = ballCloud(radius);
  const BaseVectorField whole(cloud, kTissue, sphereWindow(kVoxel));
  std::unique_ptr<DeviceWorkpiece> piece;
  const double upload = seconds([&] {
    piece = std::make_unique<DeviceWorkpiece>(BaseVectorField(cloud, kTissue, sphereWindow(kVoxel)),
                                              DeviceWorkpieceSettings{Backend::OpenCl});
  });
  const double fetch = seconds([&] { piece->field(); });
  piece->mass();
  const double mass = seconds([&] { piece->mass(); });
  const VoxelCounts counts = cloud.counts();
  std::printf(
      "%zu voxels, %.0f MB of device memory; built and uploaded in %.0f ms, downloaded in %.0f ms, "
      "mass in %.3f ms\n",
      counts.inside + counts.interface, 1e-6 * double(piece->deviceBytes()), 1e3 * upload,
      1e3 * fetch, 1e3 * mass);
  piece.reset();
  const int wide = static_cast<int>(kInner * whole.size().x()),
            thick = std::min(wide, (100000 + wide * wide - 1) / (wide * wide));
  const bool equal[] = {
      compare("adjacent", whole, adjacent(whole, {10, 10, 10}, turns), speeds),
      compare("scattered", whole, scattered(whole, 1000, turns), speeds),
      compare("adjacent", whole, adjacent(whole, {wide, wide, thick}, turns), speeds),
      compare("scattered", whole, scattered(whole, 100000, turns), speeds),
      comparePasses(whole, turns)};
  if (!std::all_of(std::begin(equal), std::end(equal), [](bool e) { return e; }))
    throw std::runtime_error("the workpieces of the device and the CPU differ");
}

}  // namespace

int main(int count, char** words) {
  try {
    double radius = 79.4;
    int turns = 40;
    bool wrong = count % 2 == 0;
    for (int i = 1; i + 1 < count; i += 2) {
      const std::string word = words[i];
      if (word == "--radius")
        radius = std::atof(words[i + 1]);
      else if (word == "--turns")
        turns = std::atoi(words[i + 1]);
      else
        wrong = true;
    }
    if (wrong || !(radius >= 10) || turns < 3)
      throw std::runtime_error("gpu_cut [--radius R] [--turns N]: R at least 10, N at least 3");
    run(radius, turns);
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "gpu_cut: %s\n", e.what());
    return 1;
  }
}
