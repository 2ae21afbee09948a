// Bodies as clouds for the tests of digital objects: a ball, a nut, a body of two materials.
#pragma once

#include <cloudcontact/voxels/cloud.h>
#include <cloudcontact/voxels/digitize.h>

#include "mesh/test_meshes.h"

namespace cloudcontact::test {

constexpr double kH = 1e-3;  // voxel of these bodies [m]

inline Cloud digitized(const Mesh& mesh, double voxel = kH) {
  DigitizeSettings settings;
  settings.voxelSize = voxel;
  settings.threads = 1;
  return digitize(mesh, settings);
}

// Radius in voxels; the center is off the lattice. The mesh has the ball's volume, and its facets
// are within 0.01 voxel of the ball.
inline Vector3d ballMiddle() {
  return kH * Vector3d(0.31, -0.17, 0.43);
}
inline Mesh ballMesh(double radius) {
  Mesh mesh = sphereMesh(radius * kH, 6);
  double volume = 0;
  for (const Vector3i& t : mesh.triangles)
    volume += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]])) / 6;
  const double grow = std::cbrt(4 * std::numbers::pi / 3 / volume) * radius * kH;
  for (Vector3d& v : mesh.vertices) v = grow * v + ballMiddle();
  return mesh;
}
inline Cloud ballCloud(double radius) {
  return digitized(ballMesh(radius));
}

// A nut without its thread: a hexagonal prism over |z| < height / 2 with a round hole through it.
// `width` is across flats.
inline Mesh nutMesh(double width, double hole, double height, int around = 120) {
  Mesh mesh;
  const double flat = 0.5 * width;
  for (int i = 0; i < around; ++i) {
    const double angle = 2 * std::numbers::pi * i / around;
    const double toFlat = std::remainder(angle, std::numbers::pi / 3);
    const Vector3d out(std::cos(angle), std::sin(angle), 0);
    for (const double z : {-0.5 * height, 0.5 * height}) {
      mesh.vertices.push_back(flat / std::cos(toFlat) * out + z * Vector3d::UnitZ());
      mesh.vertices.push_back(0.5 * hole * out + z * Vector3d::UnitZ());
    }
  }
  for (int i = 0; i < around; ++i) {
    const int a = 4 * i,
              b = 4 * ((i + 1) % around);  // outer low, inner low, outer high, inner high
    const auto quad = [&](int p, int q, int r, int s) {
      mesh.triangles.insert(mesh.triangles.end(), {{p, q, r}, {p, r, s}});
    };
    quad(a, b, b + 2, a + 2);
    quad(b + 1, a + 1, a + 3, b + 3);
    quad(a + 2, b + 2, b + 3, a + 3);
    quad(b, a, a + 1, b + 1);
  }
  return mesh;
}
// 24 voxels across flats, 8 high.
inline Cloud nutCloud() {
  return digitized(moved(nutMesh(24.3 * kH, 12.6 * kH, 8.4 * kH), oddTurn(), ballMiddle()));
}

// A ball in a box.
inline Cloud twoMaterials() {
  DigitizeSettings settings;
  settings.voxelSize = kH;
  settings.threads = 1;
  return digitize(
      {{"bone", boxMesh(Vector3d(-9.3, -8.2, -7.7) * kH, Vector3d(8.1, 9.9, 10.4) * kH)},
       {"marrow", sphereMesh(5.2 * kH, 4)}},
      settings);
}

// Expects equal coverage everywhere, and equal material wherever there is any.
inline void expectSameVoxels(const Cloud& a, const Cloud& b, int tolerance = 0) {
  ASSERT_EQ(a.voxelSize(), b.voxelSize());
  // The grids may be offset by whole voxels.
  const Vector3d apart = (b.origin() - a.origin()) / a.voxelSize();
  const Vector3i shift = apart.array().round().cast<int>();
  ASSERT_LT((apart - shift.cast<double>()).cwiseAbs().maxCoeff(), 1e-6) << "the lattices differ";
  ASSERT_EQ(a.materials(), b.materials());
  int worst = 0;
  const auto compare = [&](int x, int y, int z) {  // in a's voxels
    const int ca = a.coverage(x, y, z), cb = b.coverage(x - shift[0], y - shift[1], z - shift[2]);
    worst = std::max(worst, std::abs(ca - cb));
    if (ca > 0 && cb > 0 && !a.materials().empty()) {
      ASSERT_EQ(a.material(x, y, z), b.material(x - shift[0], y - shift[1], z - shift[2]));
    }
  };
  for (int z = 0; z < a.size()[2]; ++z)
    for (int y = 0; y < a.size()[1]; ++y)
      for (int x = 0; x < a.size()[0]; ++x) compare(x, y, z);
  for (int z = 0; z < b.size()[2]; ++z)
    for (int y = 0; y < b.size()[1]; ++y)
      for (int x = 0; x < b.size()[0]; ++x) compare(x + shift[0], y + shift[1], z + shift[2]);
  EXPECT_LE(worst, tolerance);
}

// The deviation of the cloud's coverage from that of a ball: root mean square over the voxels near
// its surface. The truth is from 16^3 samples per voxel.
inline double ballError(const Cloud& cloud, double radius, const Vector3d& middle) {
  const double h = cloud.voxelSize();
  double square = 0;
  int count = 0;
  for (int z = 0; z < cloud.size()[2]; ++z)
    for (int y = 0; y < cloud.size()[1]; ++y)
      for (int x = 0; x < cloud.size()[0]; ++x) {
        const Vector3d c = (cloud.center(x, y, z) - middle) / h;
        const double far = c.norm() - radius / h;
        double truth = far < 0 ? 1 : 0;
        if (std::abs(far) < 0.9) {
          int in = 0;
          for (int k = 0; k < 4096; ++k) {
            const Vector3d part((k % 16 + 0.5) / 16 - 0.5, (k / 16 % 16 + 0.5) / 16 - 0.5,
                                (k / 256 + 0.5) / 16 - 0.5);
            in += (c + part).norm() < radius / h;
          }
          truth = in / 4096.0;
          ++count;
        }
        const double off = cloud.coverage(x, y, z) / 255.0 - truth;
        square += off * off;
      }
  return std::sqrt(square / count);
}

}  // namespace cloudcontact::test
