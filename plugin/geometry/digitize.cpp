// From a mesh to a cloud: mend the surface, close what little is missing, cut it into columns
// (columns.cpp); where much is missing, let three axes and the winding number vote
// (open_surface.cpp).
#include <cloudcontact/digitize.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "geometry/closing.h"
#include "geometry/grid.h"
#include "geometry/materials.h"
#include "geometry/mesh_topology.h"
#include "geometry/open_surface.h"
#include "geometry/parallel.h"

namespace cloudcontact {

namespace {

// Triangles that close a surface may have this share of its area: they fill cracks and missing
// facets, and give each column an exact sum. A surface that lacks more is voted on.
constexpr double kSmallCaps = 0.1;

// A number as people write it: three digits.
std::string digits(double x) {
  std::ostringstream text;
  text << std::setprecision(3) << x;
  return text.str();
}

void checkVoxelSize(double voxelSize) {
  if (!(voxelSize > 0) || !std::isfinite(voxelSize))
    throw std::invalid_argument("digitize: voxelSize is " + digits(voxelSize) +
                                ", must be positive and finite [m]");
}

// The mesh, mended, and closed where little is missing.
struct Prepared {
  Closing closing;
  bool wasClosed = false;
  bool closable = false;  // otherwise `closing` has no caps, and the surface is open

  // Copies of the voxels that exist at once: a pass and its parts; or three, and their vote.
  int passes() const { return closable ? 2 : 5; }
};

Prepared prepare(const Mesh& mesh) {
  if (mesh.triangles.empty()) throw std::invalid_argument("digitize: the mesh has no triangles");
  Mesh surface = mended(mesh);
  if (surface.triangles.empty())
    throw std::invalid_argument("digitize: every triangle of the mesh is a line or a point");
  Prepared prepared;
  prepared.closing = closeSurface(surface);
  prepared.wasClosed = prepared.closing.wasClosed();
  prepared.closable = prepared.closing.capArea <= kSmallCaps * totalArea(surface);
  if (prepared.closable) return prepared;
  if (isSheet(surface))
    throw std::invalid_argument(
        "digitize: the mesh bounds no volume, it is a sheet; give it a thickness with shell()");
  const std::size_t triangles = surface.triangles.size();
  prepared.closing = {std::move(surface), triangles, 0};
  return prepared;
}

// Throws where the voxels would need too much, and says what would fit.
void checkSize(const Prepared& prepared, const DigitizeSettings& settings) {
  const double limit = static_cast<double>(settings.maxBytes);
  const auto bytes = [&](double h) {
    return cuttingBytes(prepared.closing, h, prepared.passes(), threadCount(settings.threads),
                        limit);
  };
  const double h = settings.voxelSize, needed = bytes(h);
  if (needed <= limit) return;
  // Tenfold steps find a size that fits, bisection the smallest such within 2 %.
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

Cloud::Voxels cutInGrid(const Prepared& prepared, const Grid& grid,
                        const DigitizeSettings& settings, DigitizeReport& found) {
  const GridSurface surface = inGrid(prepared.closing, grid);
  found.closed = prepared.wasClosed;
  if (prepared.closable) {
    ColumnResult cut =
        cutColumns(surface, cheapestAxis(surface), settings.threads, settings.progress);
    found.badColumns = cut.cappedColumns + cut.badColumns;
    return std::move(cut.voxels);
  }
  Vote vote = voteOnColumns(surface, settings.threads, settings.progress);
  found.badColumns = vote.badColumns;
  found.undecidedVoxels = vote.undecidedVoxels;
  return std::move(vote.voxels);
}

// A mesh's voxels in the grid of the body that it is part of; nothing where it has no volume.
std::optional<Cloud::Voxels> partInGrid(const Mesh& mesh, const Grid& grid,
                                        const DigitizeSettings& settings) {
  DigitizeReport unused;
  try {
    return cutInGrid(prepare(mesh), grid, settings, unused);
  } catch (const std::invalid_argument&) {
    return {};
  }
}

}  // namespace

std::size_t digitizeBytes(const Mesh& mesh, double voxelSize) {
  checkVoxelSize(voxelSize);
  const Prepared prepared = prepare(mesh);
  const double bytes =
      cuttingBytes(prepared.closing, voxelSize, prepared.passes(), threadCount(0), INFINITY);
  constexpr double kMost = 1e18;
  return static_cast<std::size_t>(std::min(bytes, kMost));
}

Cloud digitize(const Mesh& mesh, const DigitizeSettings& settings, DigitizeReport* report) {
  checkVoxelSize(settings.voxelSize);
  if (settings.threads < 0)
    throw std::invalid_argument("digitize: threads must be 0 (all cores) or positive");
  const Prepared prepared = prepare(mesh);
  checkSize(prepared, settings);
  const Grid grid = gridAround(prepared.closing.mesh, settings.voxelSize);
  DigitizeReport found;
  auto voxels = std::make_shared<Cloud::Voxels>(cutInGrid(prepared, grid, settings, found));
  checkNotEmpty(*voxels, prepared, settings.voxelSize);
  if (report) *report = found;
  return Cloud(settings.voxelSize, grid.origin, std::move(voxels));
}

Cloud digitize(const std::vector<NamedMesh>& meshes, const DigitizeSettings& settings,
               DigitizeReport* report) {
  if (meshes.empty() || meshes.size() > 256)
    throw std::invalid_argument("digitize: give from 1 to 256 meshes, each of a material");
  const Cloud body = digitize(merged(meshes), settings, report);
  if (meshes.size() == 1) return body;
  auto voxels = std::make_shared<Cloud::Voxels>(body.voxels());
  const Grid grid{body.voxelSize(), voxels->bricks.cast<double>(), body.origin()};
  Materials materials(*voxels);
  for (const NamedMesh* part : largestFirst(meshes)) {
    DigitizeSettings quiet = settings;
    quiet.progress = {};
    if (const auto own = partInGrid(part->mesh, grid, quiet)) materials.add(part->name, *own);
  }
  return Cloud(body.voxelSize(), body.origin(), std::move(voxels));
}

}  // namespace cloudcontact
