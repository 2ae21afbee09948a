// From a mesh to a cloud: repair the surface and cap small holes (preparation.cpp), then cut it
// into columns (columns.cpp). Where large parts are missing, columns along three axes and the
// winding number vote (open_surface.cpp).
#include <cloudcontact/voxels/digitize.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/parallel.h"
#include "mesh/mesh_topology.h"
#include "voxels/columns.h"
#include "voxels/open_surface.h"
#include "voxels/preparation.h"

namespace cloudcontact {

namespace {

Cloud::Voxels cutInGrid(const Prepared& prepared, const Grid& grid,
                        const DigitizeSettings& settings, DigitizeReport& found) {
  const GridSurface surface = inGrid(prepared.closing, grid, prepared.oneShell);
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

// One mesh of a body of several materials, repaired: doubled or reversed triangles would falsify
// its volume.
struct Part {
  const std::string* name;
  Prepared prepared;
  double volume;
};

// The meshes that bound a volume, largest first: a mesh inside another is smaller.
std::vector<Part> largestFirst(const std::vector<NamedMesh>& meshes) {
  std::vector<Part> parts;
  for (const NamedMesh& mesh : meshes) {
    try {
      Part part{&mesh.name, prepare(mesh.mesh), 0};
      const Mesh& closed = part.prepared.closing.mesh;
      part.volume = std::abs(sixVolumes(closed, middleOf(closed)));
      parts.push_back(std::move(part));
    } catch (const std::invalid_argument&) {  // for example a sheet
    }
  }
  std::stable_sort(parts.begin(), parts.end(),
                   [](const Part& a, const Part& b) { return a.volume > b.volume; });
  return parts;
}

// Assigns materials to a body's voxels, mesh after mesh.
class Materials {
 public:
  explicit Materials(Cloud::Voxels& body) : body_(body) {}

  // `own`: the voxels of the material's mesh in the body's grid. Voxels of whose material it holds
  // at least half become its own, also those that an earlier mesh claimed.
  void add(const std::string& name, const Cloud::Voxels& own);

 private:
  void claim(std::size_t entry, const BrickCoverage& own, std::uint8_t material);
  Cloud::Voxels& body_;
};

// Bricks of one material are stored as a code; only bricks of several store a material per voxel.
void Materials::add(const std::string& name, const Cloud::Voxels& own) {
  const auto material = static_cast<std::uint8_t>(body_.materials.size());
  body_.materials.push_back(name);
  body_.materialTable.resize(body_.table.size(), -1);
  for (std::size_t entry = 0; entry < body_.table.size(); ++entry) {
    const std::int32_t b = own.table[entry];
    if (b == kEmptyBrick || body_.table[entry] == kEmptyBrick) continue;
    std::int32_t& slot = body_.materialTable[entry];
    if (b == kSolidBrick && slot < 0)
      slot = -1 - material;
    else if (b == kSolidBrick)
      body_.material[slot].fill(material);
    else
      claim(entry, own.coverage[b], material);
  }
}

void Materials::claim(std::size_t entry, const BrickCoverage& own, std::uint8_t material) {
  std::int32_t& slot = body_.materialTable[entry];
  if (slot == -1 - material) return;
  if (slot < 0) {
    BrickMaterial even;
    even.fill(static_cast<std::uint8_t>(-1 - slot));
    slot = static_cast<std::int32_t>(body_.material.size());
    body_.material.push_back(even);
  }
  const std::int32_t b = body_.table[entry];
  BrickMaterial& brick = body_.material[slot];
  for (std::size_t v = 0; v < brick.size(); ++v) {
    const int whole = b == kSolidBrick ? 255 : body_.coverage[b][v];
    if (own[v] > 0 && 2 * own[v] >= whole) brick[v] = material;
  }
}

// Settings of task k of n equal ones, whose progress is reported as one.
DigitizeSettings piece(const DigitizeSettings& whole, std::size_t k, std::size_t n) {
  DigitizeSettings settings = whole;
  if (whole.progress)
    settings.progress = [report = whole.progress, k, n](double done) {
      report((double(k) + done) / double(n));
    };
  return settings;
}

}  // namespace

std::size_t digitizeBytes(const Mesh& mesh, double voxelSize) {
  validateVoxelSize(voxelSize);
  const Prepared prepared = prepare(mesh);
  const double bytes =
      cuttingBytes(prepared.closing, voxelSize, prepared.passes(), threadCount(0), INFINITY);
  constexpr double kMost = 1e18;
  return static_cast<std::size_t>(std::min(bytes, kMost));
}

Cloud digitize(const Mesh& mesh, const DigitizeSettings& settings, DigitizeReport* report) {
  validate(settings);
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
  validate(settings);
  const Prepared body = prepare(merged(meshes));
  int passes = body.passes();
  for (const Part& part : parts) passes = std::max(passes, part.prepared.passes());
  checkSize(body, settings, passes + 1);  // one part beside the body
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
