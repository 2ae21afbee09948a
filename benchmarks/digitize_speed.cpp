// Time to digitize a mesh, compared with OpenVDB's meshToLevelSet (half width 3, its default) on
// the same mesh, voxel size and threads in alternating turns, and with a lower bound from memory
// speed.
//   digitize_speed [MESH.obj [VOXEL_MM [THREADS [TURNS]]]]
// The mesh is in meters. Defaults: a generated M16 screw, 0.1 mm, 2 threads, 7 turns.
// OpenVDB needs Debian's libopenvdb-dev at configuration (script/bootstrap --bench).
#include <cloudcontact/mesh/mesh_file.h>
#include <cloudcontact/mesh/mesh_repair.h>
#include <cloudcontact/voxels/digitize.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "level_set_peer.h"
#include "scene/generated_mesh.h"
#include "timing.h"

namespace {

using namespace cloudcontact;

// Wall time, and processor time of all threads, which means more on a busy machine.
struct Times {
  std::vector<double> wall, processor;  // [ms] a turn

  template <typename Work>
  void add(Work&& work) {
    const std::clock_t start = std::clock();
    wall.push_back(1e3 * seconds(work));
    processor.push_back(1e3 * double(std::clock() - start) / CLOCKS_PER_SEC);
  }
  void print(const char* name) const {
    std::printf("%-11s median %.1f ms, best %.1f ms; %.1f ms of processor time\n", name,
                median(wall), *std::min_element(wall.begin(), wall.end()), median(processor));
  }
};

template <typename Work>
double medianOf(int turns, Work&& work) {
  Times times;
  for (int i = 0; i < turns; ++i) times.add(work);
  return median(times.wall);
}

// a / b for each turn.
std::vector<double> ratios(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> result;
  for (std::size_t i = 0; i < a.size(); ++i) result.push_back(a[i] / b[i]);
  return result;
}

// The lower bound for any method: write the result once, and read each triangle once.
double copyingResult(const Cloud& cloud, int turns) {
  const Cloud::Voxels& from = cloud.voxels();
  return medianOf(turns, [&] {
    Cloud::Voxels to;
    to.table = from.table, to.coverage = from.coverage;
    if (to.table.size() != from.table.size()) std::abort();
  });
}

double passingTriangles(const Mesh& mesh, int turns) {
  return medianOf(turns, [&] {
    double sum = 0;
    for (const Eigen::Vector3i& t : mesh.triangles) {
      const Vec3 &a = mesh.vertices[std::size_t(t[0])], &b = mesh.vertices[std::size_t(t[1])],
                 &c = mesh.vertices[std::size_t(t[2])];
      sum += (b - a).cross(c - a).norm();
    }
    if (!(sum > 0)) std::abort();
  });
}

// The least work of this method (plugin/voxels/columns.cpp), in doubles:
// - for each piece of a triangle in a voxel, and at least one in each interface voxel: writes and
//   reads four corners, reads and writes two differences; a cut (two crossings of 11 operations),
//   areas and moments of two triangles (15 each) and 6 to add them;
// - for each voxel of a stored brick: reads and clears its difference, writes its coverage; a sum,
//   min and max, a clamp (2), a product and a rounding sum.
constexpr double kPieceBytes = 2 * 4 * 24 + 2 * 2 * 8, kPieceOperations = 2 * 11 + 2 * 15 + 6;
constexpr double kStoredBytes = 8 + 8 + 1, kStoredOperations = 7;

// `time`: processor time [ms].
void printWork(const Mesh& mesh, const Cloud& cloud, double time, int turns) {
  const VoxelCounts counts = cloud.counts();
  const double columns = double(cloud.size()[0]) * cloud.size()[1];
  const double pieces = double(counts.interface);
  const double stored = double(cloud.voxels().coverage.size()) * kBrickVoxels;
  std::printf("voxels      %zu inside, %zu on the surface, %.0f stored, %.0f columns, %.1f MB\n",
              counts.inside, counts.interface, stored, columns, double(cloud.bytes()) / 1e6);
  std::printf("per surface voxel   at least %4.0f bytes, %3.0f operations; measured %.1f ns\n",
              kPieceBytes, kPieceOperations, 1e6 * time / pieces);
  std::printf("per stored voxel    at least %4.0f bytes, %3.0f operations\n", kStoredBytes,
              kStoredOperations);
  const double bytes = pieces * kPieceBytes + stored * kStoredBytes;
  const double operations = pieces * kPieceOperations + stored * kStoredOperations;
  std::printf("total       %.0f MB and %.0f million operations: %.1f GB/s, %.2f operations/ns\n",
              bytes / 1e6, operations / 1e6, bytes / time / 1e6, operations / (1e6 * time));
  const double copy = copyingResult(cloud, turns), pass = passingTriangles(mesh, turns);
  std::printf(
      "lower bound copy of the result %.2f ms, pass over the triangles %.2f ms: %.0f times "
      "faster\n",
      copy, pass, time / (copy + pass));
}

// Whether both describe the same body: compares volumes, and the side of voxels that the level set
// puts more than a voxel from the surface.
void printAgreement(const Mesh& mesh, const Cloud& cloud, const LevelSetPeer& peer) {
  const double truth = inspect(mesh).volume;
  std::printf("volume      mesh %.2f mm^3, digitize %+.4f %%, OpenVDB %+.4f %%\n", 1e9 * truth,
              100 * (cloud.massProperties().volume / truth - 1), 100 * (peer.volume() / truth - 1));
  std::size_t compared = 0, different = 0;
  const Eigen::Vector3i n = cloud.size();
  for (int z = 0; z < n[2]; ++z)
    for (int y = z % 3; y < n[1]; y += 3)
      for (int x = y % 5; x < n[0]; x += 5) {
        const double distance = peer.distance(cloud.center(x, y, z));
        if (std::abs(distance) < cloud.voxelSize()) continue;
        ++compared;
        different += cloud.coverage(x, y, z) != (distance < 0 ? 255 : 0);
      }
  std::printf("sides       %zu of %zu compared voxels differ\n", different, compared);
}

}  // namespace

int main(int argc, char** argv) {
  const double voxel = (argc > 2 ? std::atof(argv[2]) : 0.1) * 1e-3;
  const int threads = argc > 3 ? std::atoi(argv[3]) : 2;
  const int turns = std::max(1, argc > 4 ? std::atoi(argv[4]) : 7);
  const Mesh mesh = argc > 1 ? loadMesh(argv[1]) : program::boltMesh({}, 24e-3, 24e-3, 10e-3);
  DigitizeSettings settings;
  settings.voxelSize = voxel;
  settings.threads = threads;

  Cloud cloud;
  LevelSetPeer peer(mesh, voxel, threads);
  Times ours, theirs;
  for (int i = 0; i < turns; ++i) {
    ours.add([&] { cloud = digitize(mesh, settings); });
    if (LevelSetPeer::kAvailable) theirs.add([&] { peer.build(); });
  }
  std::printf("mesh        %zu triangles, voxels of %g mm, %d threads, median of %d turns\n",
              mesh.triangles.size(), 1e3 * voxel, threads, turns);
  ours.print("digitize");
  printWork(mesh, cloud, median(ours.processor), turns);
  if (!LevelSetPeer::kAvailable) {
    std::printf("OpenVDB     not available: install libopenvdb-dev and configure again\n");
    return 0;
  }
  theirs.print("OpenVDB");
  const std::vector<double> times = ratios(theirs.wall, ours.wall);
  std::printf("OpenVDB / digitize  median %.1f (%.1f to %.1f), in processor time %.1f\n",
              median(times), *std::min_element(times.begin(), times.end()),
              *std::max_element(times.begin(), times.end()),
              median(ratios(theirs.processor, ours.processor)));
  printAgreement(mesh, cloud, peer);
}
