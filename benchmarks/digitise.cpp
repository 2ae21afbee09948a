// Digitising a mesh beside OpenVDB's mesh to level set (half width 3, its default): the same mesh,
// voxel and number of threads, turn by turn in one run, and the floor that memory gives beside
// both.
//   digitise [MESH.obj [VOXEL_MM [THREADS [TURNS]]]]     (the mesh in metres; by default a
//   generated M16 screw, 0.1 mm, 2 threads, 7 turns)
// OpenVDB is measured where Debian's libopenvdb-dev was installed when this was configured; a peer
// of the laboratory like FCL (script/bootstrap --bench).
#include <cloudcontact/mesh/mesh_file.h>
#include <cloudcontact/mesh/mesh_repair.h>
#include <cloudcontact/voxels/digitize.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "level_set_peer.h"
#include "scene/generated_mesh.h"

namespace {

using namespace cloudcontact;
using Clock = std::chrono::steady_clock;

double median(std::vector<double> v) {
  std::nth_element(v.begin(), v.begin() + std::ptrdiff_t(v.size() / 2), v.end());
  return v[v.size() / 2];
}

// By the clock on the wall, and of all threads together: the latter tells what the work costs where
// others use the machine too.
struct Took {
  std::vector<double> wall, processor;  // [ms] a turn

  template <typename Work>
  void add(Work&& work) {
    const auto start = Clock::now();
    const std::clock_t busy = std::clock();
    work();
    processor.push_back(1e3 * double(std::clock() - busy) / CLOCKS_PER_SEC);
    wall.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
  }
  void tell(const char* name) const {
    std::printf("%-11s %.1f ms, at best %.1f; %.1f ms of all threads together\n", name,
                median(wall), *std::min_element(wall.begin(), wall.end()), median(processor));
  }
};

template <typename Work>
double medianOf(int turns, Work&& work) {
  Took took;
  for (int i = 0; i < turns; ++i) took.add(work);
  return median(took.wall);
}

// How many times the first is the second, turn by turn.
std::vector<double> ratios(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> result;
  for (std::size_t i = 0; i < a.size(); ++i) result.push_back(a[i] / b[i]);
  return result;
}

// What must be read and written whatever the method: the result once, and each triangle once.
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

// What the method must spend (plugin/geometry/columns.cpp), in doubles:
// - on a piece of a triangle in a voxel, of which each interface voxel has one at least: four
//   corners written and read, two differences read and written; a cut (two crossings of 11) and
//   two triangles' areas and moments (15 each), 6 to add them up;
// - on a voxel of a brick that stores numbers: its difference read and cleared, its coverage
//   written; a sum, two extremes, a clamp of two, a product and a sum to round.
constexpr double kPieceBytes = 2 * 4 * 24 + 2 * 2 * 8, kPieceOperations = 2 * 11 + 2 * 15 + 6;
constexpr double kStoredBytes = 8 + 8 + 1, kStoredOperations = 7;

// `took`: the processors' time [ms].
void tellBudget(const Mesh& mesh, const Cloud& cloud, double took, int turns) {
  const VoxelCounts counts = cloud.counts();
  const double columns = double(cloud.size()[0]) * cloud.size()[1];
  const double pieces = double(counts.interface);
  const double stored = double(cloud.voxels().coverage.size()) * kBrickVoxels;
  std::printf("voxels      %zu whole, %zu on the surface, %.0f stored, %.0f columns, %.1f MB\n",
              counts.inside, counts.interface, stored, columns, double(cloud.bytes()) / 1e6);
  std::printf("a surface voxel     %4.0f bytes, %3.0f operations at least;  measured %.1f ns\n",
              kPieceBytes, kPieceOperations, 1e6 * took / pieces);
  std::printf("a stored voxel      %4.0f bytes, %3.0f operations\n", kStoredBytes,
              kStoredOperations);
  const double bytes = pieces * kPieceBytes + stored * kStoredBytes;
  const double operations = pieces * kPieceOperations + stored * kStoredOperations;
  std::printf("together    %.0f MB and %.0f million operations: %.1f GB/s, %.2f a ns\n",
              bytes / 1e6, operations / 1e6, bytes / took / 1e6, operations / (1e6 * took));
  const double copy = copyingResult(cloud, turns), pass = passingTriangles(mesh, turns);
  std::printf(
      "floor       copying the result %.2f ms, a pass over the triangles %.2f ms: %.0f times "
      "less\n",
      copy, pass, took / (copy + pass));
}

// Whether the two mean the same body: volumes, and the side of each voxel that the level set puts
// more than a voxel from the surface.
void tellAgreement(const Mesh& mesh, const Cloud& cloud, const LevelSetPeer& peer) {
  const double truth = inspect(mesh).volume;
  std::printf("volume      mesh %.2f mm^3, ours %+.4f %%, OpenVDB %+.4f %%\n", 1e9 * truth,
              100 * (cloud.massProperties().volume / truth - 1), 100 * (peer.volume() / truth - 1));
  std::size_t asked = 0, others = 0;
  const Eigen::Vector3i n = cloud.size();
  for (int z = 0; z < n[2]; ++z)
    for (int y = z % 3; y < n[1]; y += 3)
      for (int x = y % 5; x < n[0]; x += 5) {
        const double distance = peer.distance(cloud.center(x, y, z));
        if (std::abs(distance) < cloud.voxelSize()) continue;
        ++asked;
        others += cloud.coverage(x, y, z) != (distance < 0 ? 255 : 0);
      }
  std::printf("sides       %zu of %zu voxels asked differ\n", others, asked);
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
  Took ours, theirs;
  for (int i = 0; i < turns; ++i) {
    ours.add([&] { cloud = digitize(mesh, settings); });
    if (LevelSetPeer::kThere) theirs.add([&] { peer.build(); });
  }
  std::printf("mesh        %zu triangles, voxels of %g mm, %d threads, median of %d turns\n",
              mesh.triangles.size(), 1e3 * voxel, threads, turns);
  ours.tell("digitize");
  tellBudget(mesh, cloud, median(ours.processor), turns);
  if (!LevelSetPeer::kThere) {
    std::printf("OpenVDB     not there: install libopenvdb-dev and configure again\n");
    return 0;
  }
  theirs.tell("OpenVDB");
  const std::vector<double> times = ratios(theirs.wall, ours.wall);
  std::printf("ratio       %.1f (median; %.1f to %.1f), of the processors' time %.1f\n",
              median(times), *std::min_element(times.begin(), times.end()),
              *std::max_element(times.begin(), times.end()),
              median(ratios(theirs.processor, ours.processor)));
  tellAgreement(mesh, cloud, peer);
}
