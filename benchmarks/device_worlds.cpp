// Bullet worlds whose cloud pairs an OpenCL device searches, beside the same worlds on all cores:
// the narrow phase of a step with transfers, the step, and the time and launches of each kernel.
//   device_worlds [--nuts N] [--pairs N] [--steps N] [--settle N] [--voxel H] [--threads N]
//                 [--reuse VOXELS] [--backend cpu|opencl]
// `nuts` rest in stacks of ten, with contacts that move with their bodies (reuse) and with every
// step searched; `pairs` are nuts pressed on threaded rods, each in a place of its own. 0 leaves
// one out. A second world on the other backend runs the same steps; all poses are equal to the bit.
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/voxels/digitize.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numbers>
#include <stdexcept>
#include <string>

#include "command.h"
#include "field/mesh_field.h"
#include "heap.h"
#include "scene/generated_mesh.h"
#include "timing.h"

namespace {

using namespace cloudcontact;

constexpr int kHigh = 10;
constexpr double kHeight = 13e-3, kWidth = 24e-3;  // of an M16 nut [m]

struct Options {
  int nuts = 10000, pairs = 1024, steps = 100, settle = 60, threads = 0;
  double voxel = 5e-4, reuse = 0.02;
  std::string backend = "opencl";
  bool device() const { return backend == "opencl"; }
};

std::shared_ptr<const SurfaceField> loweredField(Mesh mesh, double down, double voxel) {
  for (Vec3& v : mesh.vertices) v.z() -= down;
  return testing::fieldOf(mesh, voxel);
}

HeapSettings heapSettings(const Options& o, bool device) {
  HeapSettings settings;
  settings.across = kWidth / std::cos(std::numbers::pi / 6);
  settings.height = kHeight;
  settings.voxel = o.voxel;
  settings.threads = o.threads;
  settings.backend = device ? Backend::OpenCl : Backend::Cpu;
  settings.contact.bears = 100;
  settings.newton = true;  // ten sweeps do not hold stacks of ten: they fall after 3 s
  return settings;
}

bool same(const Heap& one, const Heap& other, int bodies) {
  for (int i = 0; i < bodies; ++i) {
    const Pose a = one.pose(i), b = other.pose(i);
    if (std::memcmp(a.position.data(), b.position.data(), 3 * sizeof(double)) != 0) return false;
    if (std::memcmp(a.orientation.coeffs().data(), b.orientation.coeffs().data(),
                    4 * sizeof(double)) != 0)
      return false;
  }
  return true;
}

// Times the narrow phase of each step.
void measure(Heap& heap, const char* name, int steps) {
  const CloudContactStatistics before = heap.statistics();
  const CloudDispatcherStatistics ahead = heap.dispatcher().statistics();
  std::vector<double> narrow, whole;
  for (int i = 0; i < steps; ++i) {
    const double start = heap.narrowSeconds();
    whole.push_back(heap.step());
    narrow.push_back(heap.narrowSeconds() - start);
  }
  const CloudContactStatistics after = heap.statistics();
  const CloudDispatcherStatistics now = heap.dispatcher().statistics();
  const auto each = [steps](std::size_t from, std::size_t to) { return double(to - from) / steps; };
  std::printf(
      "%-22s narrow phase %8.3f ms (worst %8.3f), step %8.3f ms; %7.1f pairs a step: %7.1f moved, "
      "%7.1f on the device, %6.1f near misses, %6.1f shapes, %6.1f without room, %6.1f finer; "
      "%.0f contacts\n",
      name, 1e3 * median(narrow), 1e3 * *std::max_element(narrow.begin(), narrow.end()),
      1e3 * median(whole), each(before.pairs, after.pairs), each(before.reused, after.reused),
      each(before.device, after.device), each(ahead.device.nearMisses, now.device.nearMisses),
      each(ahead.device.shapes, now.device.shapes), each(ahead.device.noRoom, now.device.noRoom),
      each(ahead.device.finer, now.device.finer), each(before.contacts, after.contacts));
  std::fflush(stdout);
}

void printKernels(HeapSettings settings, const Heap& settled, int steps) {
  settings.timing = true;
  Heap heap(settings);
  heap.rest(settled);
  heap.step();
  heap.step();
  heap.dispatcher().deviceTimes();
  const BatchReport before = heap.dispatcher().statistics().device;
  for (int i = 0; i < steps; ++i) heap.step();
  const BatchReport after = heap.dispatcher().statistics().device;
  double all = 0;
  int launches = 0;
  for (const auto& [name, time] : heap.dispatcher().deviceTimes()) {
    all += time.seconds;
    launches += time.calls;
    std::printf("    %-18s %10.1f us a step, %5.1f launches\n", name.c_str(),
                1e6 * time.seconds / steps, double(time.calls) / steps);
  }
  std::printf("    %-18s %10.1f us a step, %5.1f launches; %.3f MB sent, %.3f MB fetched a step\n",
              "total", 1e6 * all / steps, double(launches) / steps,
              1e-6 * double(after.sent - before.sent) / steps,
              1e-6 * double(after.fetched - before.fetched) / steps);
}

// Runs a world on the wished backend and the same one on the other, from rest after `settle` steps.
void compare(const char* name, const Options& o, const HeapSettings& settings, int bodies) {
  HeapSettings first = settings;
  Heap settled(first);
  settled.run(o.settle, 1);
  std::printf("%s: %d bodies, voxels of %g mm, reuse %g voxels%s%s\n", name, bodies, 1e3 * o.voxel,
              settings.contact.reuseMotion, o.device() ? ", on " : "",
              settled.dispatcher().device().c_str());
  Heap heap(first);
  heap.rest(settled);
  heap.run(3, 1);
  measure(heap, o.device() ? "  device" : "  cores", o.steps);
  if (!o.device()) return;
  if (const std::string why = heap.dispatcher().statistics().deviceFailure; !why.empty())
    std::printf("  the device failed: %s\n", why.c_str());
  HeapSettings second = settings;
  second.backend = Backend::Cpu;
  Heap other(second);
  other.rest(settled);
  other.run(3, 1);
  measure(other, "  cores", o.steps);
  printKernels(first, settled, std::min(o.steps, 10));
  if (!same(heap, other, bodies))
    throw std::runtime_error("the worlds of the device and the CPU differ");
  std::printf("  all poses equal to the bit\n");
}

void restingNuts(const Options& o, double reuse) {
  HeapSettings settings = heapSettings(o, o.device());
  const auto field =
      loweredField(program::nutMesh(program::Thread{}, kHeight, kWidth), kHeight / 2, o.voxel);
  const int side = static_cast<int>(std::ceil(std::sqrt(o.nuts / double(kHigh))));
  const double pitch = 2 * kWidth;  // their boxes do not meet
  settings.slab = pitch * (side + 1);
  for (int i = 0; i < o.nuts; ++i) {
    const int stack = i / kHigh, up = i % kHigh;
    const auto at = [&](int k) { return btScalar(pitch * (k - 0.5 * side)); };
    settings.places.push_back(
        btTransform(btQuaternion({0, 0, 1}, btScalar(2.4 * i)),  // the golden angle: no two alike
                    {at(stack % side), at(stack / side),
                     btScalar(kHeight * (up + 0.5) - 0.1 * o.voxel * (up + 1))}));
  }
  settings.shape = [field] { return std::make_shared<CloudShape>(field); };
  settings.contact.reuseMotion = reuse;
  compare("resting nuts", o, settings, o.nuts);
}

// Nuts a tenth of a voxel too tight on rods, in pairs: body 2k is a rod, 2k + 1 its nut.
void nutsOnRods(const Options& o) {
  HeapSettings settings = heapSettings(o, o.device());
  program::Thread wide;
  wide.clearance = -0.1 * o.voxel;
  const auto rod = loweredField(program::boltMesh(program::Thread{}, 24e-3), 0, o.voxel),
             nut = loweredField(program::nutMesh(wide, kHeight, kWidth), 0, o.voxel);
  const int side = static_cast<int>(std::ceil(std::sqrt(double(o.pairs))));
  for (int k = 0; k < o.pairs; ++k) {
    const double x = 2 * kWidth * (k % side), y = 2 * kWidth * (k / side);
    for (const double up : {0.0, 6e-3})
      settings.places.push_back(btTransform(btQuaternion::getIdentity(),
                                            btVector3(btScalar(x), btScalar(y), btScalar(up))));
  }
  settings.floats = true;
  int made = 0;
  settings.shape = [&made, rod, nut] {
    return std::make_shared<CloudShape>(made++ % 2 ? nut : rod);
  };
  settings.contact.reuseMotion = 0;
  compare("nuts on rods", o, settings, 2 * o.pairs);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App words("Worlds whose cloud pairs an OpenCL device searches", "device_worlds");
  words.add_option("--nuts", options.nuts);
  words.add_option("--pairs", options.pairs);
  words.add_option("--steps", options.steps)->check(CLI::PositiveNumber);
  words.add_option("--settle", options.settle, "steps before the clock starts");
  words.add_option("--threads", options.threads, "0: all");
  words.add_option("--voxel", options.voxel, "[m]");
  words.add_option("--reuse", options.reuse, "CloudContactSettings::reuseMotion [voxels]");
  words.add_option("--backend", options.backend)->check(CLI::IsMember({"cpu", "opencl"}));
  return runCommand(words, argc, argv, [&options] {
    if (options.nuts > 0) {
      if (options.reuse > 0) restingNuts(options, options.reuse);
      restingNuts(options, 0);
    }
    if (options.pairs > 0) nutsOnRods(options);
  });
}
