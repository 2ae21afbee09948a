// A mesh into voxels and their base vectors on an OpenCL device, beside all cores, with the same
// bits:
//   gpu_digitise [MESH.obj [SCALE]] [--voxels N] [--turns N]
// N voxels along the longest axis (512); SCALE: the file's unit [m] (1). Without a file: a rod with
// a thread. Each step on the device is told beside what it must move and compute, as shares of what
// a copy moves and of the doubles that the device computes in the same time.
#include <cloudcontact/device/digitizer.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "device/device_probe.h"
#include "mesh/thread_meshes.h"
#include "workpiece/base_vector_bricks.h"

namespace {

using namespace cloudcontact;
using Clock = std::chrono::steady_clock;

struct Arguments {
  std::string file;
  double scale = 1;
  int voxels = 512, turns = 20;

  Arguments(int count, char** words) {
    for (int i = 1; i < count; ++i) {
      const std::string word = words[i];
      const bool more = i + 1 < count;
      if (word == "--voxels" && more)
        voxels = std::atoi(words[++i]);
      else if (word == "--turns" && more)
        turns = std::atoi(words[++i]);
      else if (file.empty())
        file = word;
      else
        scale = std::atof(word.c_str());
    }
    if (voxels < 1 || turns < 1 || !(scale > 0))
      throw std::runtime_error("gpu_digitise [MESH.obj [SCALE]] [--voxels N] [--turns N]");
  }
};

// Vertices and triangles of a .obj, no more: the machine may have no Assimp.
Mesh readObj(const std::string& name, double scale) {
  std::ifstream file(name);
  if (!file) throw std::runtime_error("cannot read " + name);
  Mesh mesh;
  std::string line, word;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    words >> word;
    if (word == "v") {
      Vec3 p;
      words >> p[0] >> p[1] >> p[2];
      mesh.vertices.push_back(scale * p);
    } else if (word == "f") {
      std::vector<int> corners;
      while (words >> word) corners.push_back(std::atoi(word.c_str()) - 1);
      for (std::size_t k = 2; k < corners.size(); ++k)
        mesh.triangles.emplace_back(corners[0], corners[k - 1], corners[k]);
    }
  }
  return mesh;
}

double longestAxis(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& v : mesh.vertices) box.extend(v);
  return box.sizes().maxCoeff();
}

template <typename Work>
double seconds(Work&& work) {
  const auto begin = Clock::now();
  work();
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

// The first two turns make room and are not counted.
template <typename Work>
double median(int turns, Work&& work) {
  std::vector<double> took;
  for (int i = -2; i < turns; ++i) {
    const double t = seconds(work);
    if (i >= 0) took.push_back(t);
  }
  std::nth_element(took.begin(), took.begin() + std::ptrdiff_t(took.size() / 2), took.end());
  return took[took.size() / 2];
}

const TissueTable kTissue{{"steel", 1e6, 10, 1e9, 7850}};

struct Case {
  Mesh mesh;
  DigitizeSettings settings;
  WindowSettings window;
};

bool same(const Cloud& a, const Cloud& b) {
  return a.origin() == b.origin() && a.voxels().table == b.voxels().table &&
         a.voxels().coverage == b.voxels().coverage;
}

bool same(const BaseVectorField& a, const BaseVectorField& b) {
  const BaseVectorField::Bricks &p = a.bricks(), &q = b.bricks();
  return p.table == q.table && p.blocks.size() == q.blocks.size() &&
         std::memcmp(static_cast<const void*>(p.blocks.data()),
                     static_cast<const void*>(q.blocks.data()),
                     p.blocks.size() * sizeof(FieldBlock)) == 0;
}

// What a step must move at least [bytes], and compute [operations], in doubles or in floats.
struct Floor {
  double bytes = 0, operations = 0;
  bool floats = false;
};

// The pieces of triangles in voxels are at least the voxels on the surface; a piece costs a cut
// (two crossings of 11), two triangles' areas and moments (15 each) and 6 to add them up, as
// benchmarks/digitise.cpp counts it.
Floor floorOf(const std::string& step, const DeviceDigitizeReport& r, double surface) {
  const double t = double(r.triangles), listed = double(r.listed), touched = double(r.touched),
               stored = double(r.stored), blocks = double(r.blocks);
  constexpr double kTriangle = 12 + 72, kPiece = 16, kFound = 64 * 8, kPieceOperations = 58;
  if (step == "ccCountColumns") return {t * kTriangle + 4 * listed, 30 * listed};
  if (step == "ccListColumns") return {t * kTriangle + 8 * listed, 30 * listed};
  if (step == "ccSortColumns") return {8 * listed, 0};
  if (step == "ccCutColumns")
    return {listed * (8 + kTriangle + kFound) + surface * kPiece, surface * kPieceOperations};
  if (step == "ccAddPieces")
    return {listed * kFound + surface * kPiece + touched * 4096, surface * 2};
  if (step == "ccSumColumns") return {touched * 4096, touched * 512 * 3};
  if (step == "ccStoreBricks") return {touched * 4096 + stored * 512, touched * 512 * 3};
  if (step == "ccSumWindows" || step == "ccSumAnyWindows")
    return {stored * 512 + blocks * sizeof(FieldBlock), blocks * 512 * double(r.taps) * 8,
            step == "ccSumWindows"};
  if (step == "mesh sent") return {double(r.sent), 0};
  return {};
}

void tellSteps(const Arguments& how, const Case& c, const DeviceSpeeds& speeds, double surface) {
  Digitizer digitizer({Backend::OpenCl, true});
  const auto run = [&] { digitizer.run(c.mesh, c.settings, kTissue, c.window); };
  run();
  digitizer.deviceTimes();
  for (int i = 0; i < how.turns; ++i) run();
  const DeviceDigitizeReport& r = digitizer.deviceReport();
  std::printf(
      "%zu triangles, %zu times over columns of 8 voxels, %zu places for pieces, %zu bricks "
      "touched, %zu stored, %zu blocks of sums, %zu taps a window; %.3f MB sent, %.0f MB on the "
      "device\n",
      r.triangles, r.listed, r.places, r.touched, r.stored, r.blocks, r.taps, 1e-6 * double(r.sent),
      1e-6 * double(digitizer.deviceBytes()));
  std::printf("%-18s %10s %13s %10s %15s %12s\n", "on the device", "us a turn", "must move MB",
              "of a copy", "M operations", "of doubles");
  double all = 0;
  for (const auto& [name, time] : digitizer.deviceTimes()) {
    const double each = time.seconds / how.turns;
    const Floor f = floorOf(name, r, surface);
    all += each;
    std::printf("%-18s %10.1f %13.3f %9.1f%% %15.1f ", name.c_str(), 1e6 * each, 1e-6 * f.bytes,
                100 * f.bytes / each / speeds.copy, 1e-6 * f.operations);
    if (f.floats)
      std::printf("%12s\n", "floats");
    else
      std::printf("%11.1f%%\n", 100 * f.operations / each / speeds.doubles);
  }
  std::printf("%-18s %10.1f\n", "together", 1e6 * all);
}

void run(const Arguments& how) {
  const DeviceSpeeds speeds = measureDevice();
  std::printf(
      "%s: copy %.1f GB/s, doubles %.0f G/s, upload %.1f GB/s, download %.1f GB/s, launch %.1f "
      "us\n",
      speeds.device.c_str(), 1e-9 * speeds.copy, 1e-9 * speeds.doubles, 1e-9 * speeds.upload,
      1e-9 * speeds.download, 1e6 * speeds.launch);
  Case c;
  c.mesh = how.file.empty() ? threadedRod({}, 41e-3) : readObj(how.file, how.scale);
  c.settings.voxelSize = longestAxis(c.mesh) / how.voxels;
  c.window = sphereWindow(c.settings.voxelSize);
  Digitizer device({Backend::OpenCl});
  if (device.backend() != Backend::OpenCl) throw std::runtime_error(device.message());
  const auto both = [&] { device.run(c.mesh, c.settings, kTissue, c.window); };
  both();
  if (!device.deviceReport().onDevice) throw std::runtime_error(device.message());
  const std::size_t rounds = device.deviceReport().rounds;
  Cloud cloud;
  const double cpuVoxels = seconds([&] { cloud = digitize(c.mesh, c.settings); });
  std::optional<BaseVectorField> field;
  const double cpuField = seconds([&] { field.emplace(cloud, kTissue, c.window); });
  const bool voxelsSame = same(device.cloud(), cloud), fieldSame = same(device.field(), *field);
  const Eigen::Vector3i n = cloud.size();
  std::printf("voxels of %.4g mm, grid %d x %d x %d: %s the CPU's to the bit, sums %s\n",
              1e3 * cloud.voxelSize(), n[0], n[1], n[2], voxelsSame ? "equal to" : "UNLIKE",
              fieldSame ? "equal" : "UNLIKE");
  const double gpu = median(how.turns, both);
  const double gpuVoxels = median(how.turns, [&] { device.run(c.mesh, c.settings); });
  const double fetch = seconds([&] { device.cloud(); });
  std::printf(
      "from the mesh to voxels and sums on the device, median of %d: %.3f ms (voxels alone %.3f); "
      "the first time %zu rounds; fetching the voxels %.3f ms more\n",
      how.turns, 1e3 * gpu, 1e3 * gpuVoxels, rounds, 1e3 * fetch);
  std::printf("%u cores: voxels %.1f ms, sums %.1f ms: %.0f times that\n",
              std::thread::hardware_concurrency(), 1e3 * cpuVoxels, 1e3 * cpuField,
              (cpuVoxels + cpuField) / gpu);
  tellSteps(how, c, speeds, double(cloud.counts().interface));
  if (!voxelsSame || !fieldSame) throw std::runtime_error("the device's voxels are not the CPU's");
}

}  // namespace

int main(int count, char** words) {
  try {
    run(Arguments(count, words));
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "gpu_digitise: %s\n", e.what());
    return 1;
  }
}
