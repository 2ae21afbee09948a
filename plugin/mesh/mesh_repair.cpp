// Inspects and repairs meshes: see mesh_repair.h.
#include <cloudcontact/mesh/mesh_repair.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mesh/closing.h"
#include "mesh/mesh_orientation.h"
#include "mesh/mesh_topology.h"
#include "mesh/winding.h"

namespace cloudcontact {

using Eigen::Vector3d;
using Eigen::Vector3i;

namespace {

// Holes up to this share of the surface's area make no sheet, without a look at winding numbers.
constexpr double kSmallHoles = 0.1;
// Least mean winding number just behind the faces of a body. It is 1 for a closed body, 0.87 for a
// cube without one face, 0.75 for a hemisphere without its base, 1/2 for a flat sheet.
constexpr double kBodyWinding = 0.7;
constexpr int kProbes = 64;

// The mean winding number just behind the faces, at probes spread evenly over the area.
double windingBehind(const Mesh& mesh) {
  const double area = totalArea(mesh);
  const double behind = 1e-4 * std::sqrt(area);
  double passed = 0, sum = 0;
  int probes = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    passed += triangleArea(mesh, t);
    int here = 0;
    while (probes < kProbes && (probes + 0.5) / kProbes * area <= passed) ++probes, ++here;
    if (here == 0) continue;
    const Vector3i& v = mesh.triangles[t];
    const Vector3d &a = mesh.vertices[v[0]], &b = mesh.vertices[v[1]], &c = mesh.vertices[v[2]];
    const Vector3d normal = (b - a).cross(c - a).normalized();
    sum += here * windingNumber(mesh, (a + b + c) / 3 - behind * normal);
  }
  return probes > 0 ? sum / probes : 1;
}

// Takes a welded mesh whose triangles agree in direction.
bool boundsNothing(const Mesh& mesh) {
  const Closing closing = closeSurface(mesh);
  if (closing.capArea <= kSmallHoles * totalArea(mesh)) return false;
  // A body that faces inward has winding numbers of -1 before its faces and 0 behind.
  const double winding = windingBehind(mesh);
  return std::max(winding, 1 - winding) < kBodyWinding;
}

Mesh agreeing(const Mesh& mesh, double tolerance) {
  validate(mesh);
  Mesh result = welded(mesh, tolerance);
  dropDoubles(result);
  agreeInDirection(result);
  return result;
}

}  // namespace

MeshReport inspect(const Mesh& mesh) {
  validate(mesh);
  const Mesh clean = welded(mesh, 0);
  MeshReport report;
  report.degenerateTriangles = mesh.triangles.size() - clean.triangles.size();
  forEachEdge(sortedEdgeSides(clean), [&](const EdgeSide* first, const EdgeSide* last) {
    if (last - first == 1) ++report.openEdges;
    if (last - first > 2) ++report.overusedEdges;
  });
  report.volume = sixVolumes(clean, middleOf(clean)) / 6;
  report.area = totalArea(clean);
  return report;
}

Mesh mended(const Mesh& mesh, double tolerance, bool* sheet) {
  Mesh result = agreeing(mesh, tolerance);
  const bool isOpen = boundsNothing(result);
  if (sheet) *sheet = isOpen;
  if (isOpen) return result;  // the volume of a sheet has no meaningful sign
  if (sixVolumes(result, middleOf(result)) < 0)
    for (Vector3i& t : result.triangles) flip(t);
  turnStrayComponents(result);
  return result;
}

bool isSheet(const Mesh& mesh) {
  return boundsNothing(agreeing(mesh, 0));
}

namespace {

// Vertex normals by which the faces move by 1: the mean of the triangles' normals weighted by their
// angles, lengthened where it leans away from the faces, at most twofold to avoid spikes.
std::vector<Vector3d> offsetNormals(const Mesh& mesh) {
  std::vector<Vector3d> normals(mesh.vertices.size(), Vector3d::Zero());
  std::vector<double> lean(mesh.vertices.size(), 0), angles(mesh.vertices.size(), 0);
  const auto forEachCorner = [&](auto&& visit) {
    for (const Vector3i& t : mesh.triangles)
      for (int k = 0; k < 3; ++k) {
        const Vector3d& p = mesh.vertices[t[k]];
        const Vector3d b = mesh.vertices[t[(k + 1) % 3]] - p, c = mesh.vertices[t[(k + 2) % 3]] - p;
        const Vector3d cross = b.cross(c);
        if (cross.norm() > 0) visit(t[k], cross.normalized(), std::atan2(cross.norm(), b.dot(c)));
      }
  };
  forEachCorner([&](int v, const Vector3d& n, double angle) { normals[v] += angle * n; });
  for (Vector3d& n : normals) n.normalize();
  forEachCorner([&](int v, const Vector3d& n, double angle) {
    lean[v] += angle * n.dot(normals[v]);
    angles[v] += angle;
  });
  for (std::size_t v = 0; v < normals.size(); ++v)
    normals[v] *= angles[v] > 0 ? 1 / std::max(0.5, lean[v] / angles[v]) : 0;
  return normals;
}

}  // namespace

Mesh shell(const Mesh& mesh, double thickness) {
  if (!(thickness > 0) || !std::isfinite(thickness))
    throw std::invalid_argument("shell: thickness must be positive and finite [m]");
  Mesh result = agreeing(mesh, 0);
  std::vector<Vector3d> behind = offsetNormals(result);
  for (Vector3d& b : behind) b *= -thickness;
  return thickened(std::move(result), behind);
}

}  // namespace cloudcontact
