// Prepares meshes for digitizing: see preparation.h.
#include "voxels/preparation.h"

#include <cloudcontact/mesh/mesh_repair.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "base/parallel.h"
#include "mesh/mesh_orientation.h"
#include "mesh/mesh_topology.h"

namespace cloudcontact {

namespace {

// Caps may have this share of the surface's area: they fill cracks and missing facets, and make the
// sum of each column exact. Surfaces with larger holes go through open_surface.cpp.
constexpr double kSmallCaps = 0.1;

// A number with three digits.
std::string digits(double x) {
  std::ostringstream text;
  text << std::setprecision(3) << x;
  return text.str();
}

}  // namespace

void validateVoxelSize(double voxelSize) {
  if (!(voxelSize > 0) || !std::isfinite(voxelSize))
    throw std::invalid_argument("digitize: voxelSize is " + digits(voxelSize) +
                                ", must be positive and finite [m]");
}

void validate(const DigitizeSettings& settings) {
  validateVoxelSize(settings.voxelSize);
  if (settings.threads < 0)
    throw std::invalid_argument("digitize: threads must be 0 (all cores) or positive");
}

std::optional<Prepared> preparedAsWhole(const Mesh& mesh) {
  validate(mesh);
  Prepared prepared;
  Mesh& whole = prepared.closing.mesh;
  whole = welded(mesh, 0);
  const double volume = sixVolumes(whole, middleOf(whole));
  if (volume == 0) return std::nullopt;
  if (volume < 0)
    for (Eigen::Vector3i& t : whole.triangles) flip(t);
  prepared.closing.firstCap = whole.triangles.size();
  prepared.wasClosed = prepared.closable = prepared.oneShell = true;
  return prepared;
}

Prepared prepare(const Mesh& mesh) {
  if (mesh.triangles.empty()) throw std::invalid_argument("digitize: the mesh has no triangles");
  if (std::optional<Prepared> whole = preparedAsWhole(mesh);
      whole && isOneClosedSurface(whole->closing.mesh))
    return std::move(*whole);
  bool sheet = false;
  Mesh surface = mended(mesh, 0, &sheet);
  if (surface.triangles.empty())
    throw std::invalid_argument("digitize: every triangle of the mesh is a line or a point");
  Prepared prepared;
  prepared.closing = closeSurface(surface);
  prepared.wasClosed = prepared.closing.wasClosed();
  prepared.closable = prepared.closing.capArea <= kSmallCaps * totalArea(surface);
  if (prepared.closable) return prepared;
  if (sheet)
    throw std::invalid_argument(
        "digitize: the mesh bounds no volume, it is a sheet; give it a thickness with shell()");
  const std::size_t triangles = surface.triangles.size();
  prepared.closing = {std::move(surface), triangles, 0};
  return prepared;
}

void checkSize(const Prepared& prepared, const DigitizeSettings& settings, int passes) {
  const double limit = settings.maxBytes;
  const int threads = threadCount(settings.threads);
  if (fullGridBytes(prepared.closing, settings.voxelSize, passes, threads) <= limit) return;
  const auto bytes = [&](double h) {
    return cuttingBytes(prepared.closing, h, passes, threads, limit);
  };
  const double h = settings.voxelSize, needed = bytes(h);
  if (needed <= limit) return;
  // Steps of 10 find a size that fits, bisection the smallest within 2 %.
  double tooSmall = h, fits = 10 * h;
  while (bytes(fits) > limit && fits < 1e300) tooSmall = fits, fits *= 10;
  while (fits / tooSmall > 1.02) {
    const double middle = std::sqrt(fits / tooSmall) * tooSmall;
    (bytes(middle) > limit ? tooSmall : fits) = middle;
  }
  throw std::length_error("digitize: voxels of " + digits(h) + " m would need at least " +
                          digits(needed / 1e6) + " MB, maxBytes allows " + digits(limit / 1e6) +
                          " MB; choose a voxelSize of " + digits(1.01 * fits) +
                          " m or larger, or raise maxBytes");
}

void checkNotEmpty(const Cloud::Voxels& voxels, const Prepared& prepared, double voxelSize) {
  const auto full = [](std::int32_t b) { return b != kEmptyBrick; };
  if (std::any_of(voxels.table.begin(), voxels.table.end(), full)) return;
  const Mesh& mesh = prepared.closing.mesh;
  const double volume = sixVolumes(mesh, middleOf(mesh)) / 6;
  throw std::invalid_argument(
      "digitize: the mesh encloses " + digits(volume) + " m^3, nothing that voxels of " +
      digits(voxelSize) + " m could hold; choose a smaller voxelSize, or, if it is a sheet, give " +
      "it a thickness with shell()");
}

}  // namespace cloudcontact
