// From a mesh to a cloud: mend the surface, close what little is missing, cut it into columns
// (columns.cpp); where much is missing, let three axes and the winding number vote
// (open_surface.cpp).
#include <cloudcontact/digitize.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
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

// Throws where that many copies of the voxels would need too much, and says what would fit.
void checkSize(const Prepared& prepared, const DigitizeSettings& settings, int passes) {
  const double limit = static_cast<double>(settings.maxBytes);
  const int threads = threadCount(settings.threads);
  if (fullGridBytes(prepared.closing, settings.voxelSize, passes, threads) <= limit) return;
  const auto bytes = [&](double h) {
    return cuttingBytes(prepared.closing, h, passes, threads, limit);
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

// A mesh of a body of several materials, mended: as files have them they may be doubled or wrongly
// turned, and count for more or less than the volume that they bound.
struct Part {
  const std::string* name;
  Prepared prepared;
  double volume;
};

// Those that bound a volume, by its size: what lies within another is smaller.
std::vector<Part> largestFirst(const std::vector<NamedMesh>& meshes) {
  std::vector<Part> parts;
  for (const NamedMesh& mesh : meshes) {
    try {
      Part part{&mesh.name, prepare(mesh.mesh), 0};
      const Mesh& closed = part.prepared.closing.mesh;
      part.volume = std::abs(sixVolumes(closed, middleOf(closed)));
      parts.push_back(std::move(part));
    } catch (const std::invalid_argument&) {  // a sheet, say
    }
  }
  std::stable_sort(parts.begin(), parts.end(),
                   [](const Part& a, const Part& b) { return a.volume > b.volume; });
  return parts;
}

// The k-th of n equal pieces of a work that is told of as one.
DigitizeSettings piece(const DigitizeSettings& whole, std::size_t k, std::size_t n) {
  DigitizeSettings settings = whole;
  if (whole.progress)
    settings.progress = [told = whole.progress, k, n](double done) {
      told((double(k) + done) / double(n));
    };
  return settings;
}

void checkSettings(const DigitizeSettings& settings) {
  checkVoxelSize(settings.voxelSize);
  if (settings.threads < 0)
    throw std::invalid_argument("digitize: threads must be 0 (all cores) or positive");
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
  checkSettings(settings);
  const Prepared prepared = prepare(mesh);
  checkSize(prepared, settings, prepared.passes());
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
  const std::vector<Part> parts = largestFirst(meshes);
  if (parts.size() < 2) return digitize(merged(meshes), settings, report);
  checkSettings(settings);
  const Prepared body = prepare(merged(meshes));
  int passes = body.passes();
  for (const Part& part : parts) passes = std::max(passes, part.prepared.passes());
  checkSize(body, settings, passes + 1);  // a part is cut while the body is there
  const Grid grid = gridAround(body.closing.mesh, settings.voxelSize);
  const std::size_t pieces = parts.size() + 1;
  DigitizeReport found, unused;
  auto voxels =
      std::make_shared<Cloud::Voxels>(cutInGrid(body, grid, piece(settings, 0, pieces), found));
  checkNotEmpty(*voxels, body, settings.voxelSize);
  Materials materials(*voxels);
  for (std::size_t k = 0; k < parts.size(); ++k)
    materials.add(*parts[k].name,
                  cutInGrid(parts[k].prepared, grid, piece(settings, k + 1, pieces), unused));
  if (report) *report = found;
  return Cloud(settings.voxelSize, grid.origin, std::move(voxels));
}

}  // namespace cloudcontact
