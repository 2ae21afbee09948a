// Time to digitize a mesh and to sum its base vectors on an OpenCL device, compared with all cores.
// Both give the same bits.
//   gpu_digitize [MESH.obj [SCALE]] [--voxels N] [--turns N]
// N voxels along the longest axis (512); SCALE: the file's unit [m] (1). By default a threaded rod.
// Each kernel is compared with the bytes it must move and the operations it must do, as shares of
// the device's peak speeds.
#include <cloudcontact/device/digitizer.h>

#include <algorithm>
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

#include "device_speeds.h"
#include "field/base_vector_bricks.h"
#include "mesh/thread_meshes.h"
#include "timing.h"

namespace {

using namespace cloudcontact;

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
      throw std::runtime_error("gpu_digitize [MESH.obj [SCALE]] [--voxels N] [--turns N]");
  }
};

// Reads vertices and faces of a .obj without Assimp, which the machine may lack.
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

// Median time [s]. The first two turns allocate memory and do not count.
template <typename Work>
double turnTime(int turns, Work&& work) {
  std::vector<double> times;
  for (int i = -2; i < turns; ++i) {
    const double time = seconds(work);
    if (i >= 0) times.push_back(time);
  }
  return median(times);
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
         std::memcmp(p.blocks.data(), q.blocks.data(), p.blocks.size() * sizeof(FieldBlock)) == 0;
}

// The least work of a kernel: bytes to move, and operations on doubles or floats.
struct Work {
  double bytes = 0, operations = 0;
  bool floats = false;
};

// There is at least one piece of a triangle in each surface voxel. A piece takes 58 operations, as
// in benchmarks/digitize_speed.cpp.
Work leastWork(const std::string& step, const DeviceDigitizeReport& r, double surface) {
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

void printKernels(const Arguments& how, const Case& c, const DeviceSpeeds& speeds, double surface) {
  Digitizer digitizer({Backend::OpenCl, true});
  const auto run = [&] { digitizer.run(c.mesh, c.settings, kTissue, c.window); };
  run();
  digitizer.deviceTimes();
  for (int i = 0; i < how.turns; ++i) run();
  const DeviceDigitizeReport& r = digitizer.deviceReport();
  std::printf(
      "%zu triangles, %zu entries in columns of bricks, %zu places for pieces, %zu bricks touched, "
      "%zu stored, %zu blocks of sums, %zu taps a window; %.3f MB uploaded, %.0f MB of device "
      "memory\n",
      r.triangles, r.listed, r.places, r.touched, r.stored, r.blocks, r.taps, 1e-6 * double(r.sent),
      1e-6 * double(digitizer.deviceBytes()));
  std::printf("%-18s %10s %13s %10s %15s %12s\n", "on the device", "us a turn", "must move MB",
              "of copy", "M operations", "of doubles");
  double all = 0;
  for (const auto& [name, time] : digitizer.deviceTimes()) {
    const double each = time.seconds / how.turns;
    const Work w = leastWork(name, r, surface);
    all += each;
    std::printf("%-18s %10.1f %13.3f %9.1f%% %15.1f ", name.c_str(), 1e6 * each, 1e-6 * w.bytes,
                100 * w.bytes / each / speeds.copy, 1e-6 * w.operations);
    if (w.floats)
      std::printf("%12s\n", "floats");
    else
      std::printf("%11.1f%%\n", 100 * w.operations / each / speeds.doubles);
  }
  std::printf("%-18s %10.1f\n", "total", 1e6 * all);
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
  std::printf("voxels of %.4g mm, grid %d x %d x %d: voxels %s as on the CPU, sums %s\n",
              1e3 * cloud.voxelSize(), n[0], n[1], n[2], voxelsSame ? "the same" : "NOT the same",
              fieldSame ? "the same" : "NOT the same");
  const double gpu = turnTime(how.turns, both);
  const double gpuVoxels = turnTime(how.turns, [&] { device.run(c.mesh, c.settings); });
  const double fetch = seconds([&] { device.cloud(); });
  std::printf(
      "device: voxels and sums %.3f ms (voxels only %.3f ms), median of %d; %zu rounds in the "
      "first "
      "run; download of the voxels %.3f ms\n",
      1e3 * gpu, 1e3 * gpuVoxels, how.turns, rounds, 1e3 * fetch);
  std::printf("%u cores: voxels %.1f ms, sums %.1f ms: %.0f times as long\n",
              std::thread::hardware_concurrency(), 1e3 * cpuVoxels, 1e3 * cpuField,
              (cpuVoxels + cpuField) / gpu);
  printKernels(how, c, speeds, double(cloud.counts().interface));
  if (!voxelsSame || !fieldSame)
    throw std::runtime_error("the voxels of the device and the CPU differ");
}

}  // namespace

int main(int count, char** words) {
  try {
    run(Arguments(count, words));
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "gpu_digitize: %s\n", e.what());
    return 1;
  }
}
