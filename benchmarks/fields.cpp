// Building a surface field, and loading it from a file, in processor time of one core; and how well
// the field tells the mesh it was made from: its depth at points of the mesh, which is 0 in truth,
// and the angle between its normal and the triangle's. At edges that angle has no bound.
//   fields [FOLDER OF MESHES]
#include <cloudcontact/field/field_file.h>
#include <cloudcontact/mesh/mesh_file.h>
#include <cloudcontact/voxels/digitize.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <numeric>
#include <random>
#include <string>

#include "timing.h"
#include "torus.h"

namespace {

using namespace cloudcontact;

constexpr int kPoints = 100000, kLoads = 9;

template <typename Work>
double spent(Work&& work) {
  const double start = threadSeconds();
  work();
  return threadSeconds() - start;
}

struct Errors {
  std::vector<double> depth, normal;  // [voxels], [deg]
};

Errors errorsOf(const SurfaceField& field, const Mesh& mesh) {
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<double> sums;
  const auto corner = [&](std::size_t t, int k) { return mesh.vertices[mesh.triangles[t][k]]; };
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    sums.push_back(area += (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).norm());
  Errors errors;
  for (int k = 0; k < kPoints; ++k) {
    const auto found = std::lower_bound(sums.begin(), sums.end(), share(engine) * area);
    const auto t = std::size_t(std::min(found, sums.end() - 1) - sums.begin());
    double u = share(engine), v = share(engine);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Vec3 a = corner(t, 1) - corner(t, 0), b = corner(t, 2) - corner(t, 0);
    const auto point = field.at(corner(t, 0) + u * a + v * b);
    if (!point) continue;
    const double cosine = point->normal.dot(a.cross(b).normalized());
    errors.depth.push_back(std::abs(point->depth) / field.cloud().voxelSize());
    errors.normal.push_back(std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi);
  }
  return errors;
}

double at(std::vector<double> values, double share) {
  const auto k = std::ptrdiff_t(share * double(values.size()));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[std::size_t(k)];
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

// `voxel` [m], or the number of voxels across the longest side if it is above 1.
void measure(const char* name, const Mesh& mesh, double voxel) {
  Eigen::AlignedBox3d bounds;
  for (const Vec3& v : mesh.vertices) bounds.extend(v);
  DigitizeSettings how;
  how.voxelSize = voxel > 1 ? bounds.sizes().maxCoeff() / voxel : voxel;
  how.threads = 1;
  const Cloud cloud = digitize(mesh, how);
  FieldSettings settings;
  settings.threads = 1;
  std::shared_ptr<const SurfaceField> field;
  const double built = spent([&] { field = SurfaceField::build(cloud, settings); });
  const auto file = std::filesystem::temp_directory_path() / "cloudcontact_fields_benchmark.field";
  saveField(*field, file);
  std::vector<double> loads;
  for (int k = 0; k < kLoads; ++k) loads.push_back(spent([&] { loadField(file); }));
  const double loaded = median(loads);
  const Errors e = errorsOf(*field, mesh);
  std::printf("%-22s %7.0f %7.2f %9.1f %7.0f %8.1f   %.4f %.4f   %.2f %5.2f\n", name, built * 1e3,
              loaded * 1e3, double(std::filesystem::file_size(file)) / 1e6, built / loaded,
              built * 1e6 / double(field->sampleCount()), mean(e.depth), at(e.depth, 0.99),
              mean(e.normal), at(e.normal, 0.99));
  std::filesystem::remove(file);
}

}  // namespace

int main(int count, char** arguments) {
  const std::string folder = count > 1 ? arguments[1] : "../shared/data";
  std::printf("%-22s %7s %7s %9s %7s %8s   %s\n", "", "build", "load", "file", "ratio", "a sample",
              "depth: mean, 99 %   normal: mean, 99 %");
  std::printf("%-22s %7s %7s %9s %7s %8s   %s\n", "", "[ms]", "[ms]", "[MB]", "", "[us]",
              "[voxels]            [deg]");
  measure("spot, 100 across", loadMesh(folder + "/spot.obj"), 100);
  measure("torus of 64 x 32, 100", torusMesh(1, 0.4, 64, 32), 100);
  measure("torus of 200 x 100, 100", torusMesh(1, 0.4, 200, 100), 100);
  measure("M16 bolt, 0.25 mm", loadMesh(folder + "/bolt_m16_loose.obj"), 2.5e-4);
  measure("M16 nut, 0.25 mm", loadMesh(folder + "/nut_m16_loose.obj"), 2.5e-4);
}
