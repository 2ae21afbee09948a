// The voxel of a body for which none is stated: a hundredth of its diagonal, or down to half of
// that where the body is finely cut.
//
// What counts are chords, the stretches between neighboring crossings of a line with the surface,
// inside or outside, where the two faces face each other or away from each other: a wall's
// thickness or a groove's width. A chord across a body's edge is neither. Lines along the three
// axes cross the body a voxel apart. A wall wants two voxels. Where walls and grooves follow each
// other, as in a thread, each wants five in the mean, which is ten a pitch: an M16 nut at a
// hundredth of its diagonal, five voxels a pitch, stands on false touches of its crests and turns
// down its bolt half as fast (docs/measurements.md, "Bodies that nearly touch"). A tenth of all
// chords may want more.
#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/digitize.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <vector>

namespace cloudcontact {

namespace {

constexpr double kOfDiagonal = 0.01, kLeastOfDiagonal = 0.005;
constexpr double kVoxelsInWall = 2, kVoxelsInRib = 5;
constexpr double kShareOfChords = 0.1;
// The cosine between normals that face each other or away. The flanks of a thread of 60 deg have
// -0.5.
constexpr double kOpposed = -0.4;
// Lines through an edge cross two faces in one place [voxels].
constexpr double kNoChord = 0.05;
// Triangles overlap few lines in all, unless a mesh is no surface; such a mesh gets the hundredth.
constexpr std::size_t kMostTries = std::size_t{1} << 24, kMostCrossings = std::size_t{1} << 22;

struct LineCrossing {
  std::uint32_t line;
  double at;  // along the line [m]
  std::uint32_t triangle;
};

// Lines along one axis, `spacing` [m] apart.
class Lines {
 public:
  Lines(const Eigen::AlignedBox3d& bounds, int axis, double spacing)
      : axis_(axis), u_((axis + 1) % 3), w_((axis + 2) % 3), spacing_(spacing), low_(bounds.min()) {
    along_ = countOf(bounds.sizes()[u_]);
    across_ = countOf(bounds.sizes()[w_]);
  }

  // False where there are too many.
  bool cross(const Mesh& mesh, std::vector<LineCrossing>& found) const {
    std::size_t tried = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      tried += crossTriangle(mesh, t, found);
      if (tried > kMostTries || found.size() > kMostCrossings) return false;
    }
    return true;
  }

 private:
  std::int64_t countOf(double size) const { return static_cast<std::int64_t>(size / spacing_) + 1; }

  // Returns the number of lines that were tried.
  std::size_t crossTriangle(const Mesh& mesh, std::size_t t,
                            std::vector<LineCrossing>& found) const {
    const auto& corners = mesh.triangles[t];
    Vec3 p[3];
    for (int k = 0; k < 3; ++k)
      p[k] = (mesh.vertices[static_cast<std::size_t>(corners[k])] - low_) / spacing_;
    const Vec3 b = p[1] - p[0], c = p[2] - p[0];
    const double area = b[u_] * c[w_] - c[u_] * b[w_];
    if (area == 0) return 0;  // along the lines
    const auto first = [](double least) {
      return std::max<std::int64_t>(0, static_cast<std::int64_t>(std::ceil(least - 0.5)));
    };
    const double mostU = std::max({p[0][u_], p[1][u_], p[2][u_]}),
                 mostW = std::max({p[0][w_], p[1][w_], p[2][w_]});
    const std::int64_t beginW = first(std::min({p[0][w_], p[1][w_], p[2][w_]}));
    std::size_t tried = 0;
    for (std::int64_t i = first(std::min({p[0][u_], p[1][u_], p[2][u_]}));
         i < along_ && static_cast<double>(i) + 0.5 <= mostU; ++i)
      for (std::int64_t j = beginW; j < across_ && static_cast<double>(j) + 0.5 <= mostW; ++j) {
        ++tried;
        const double u = static_cast<double>(i) + 0.5 - p[0][u_],
                     w = static_cast<double>(j) + 0.5 - p[0][w_];
        const double towardB = (u * c[w_] - c[u_] * w) / area,
                     towardC = (b[u_] * w - u * b[w_]) / area;
        if (towardB < 0 || towardC < 0 || towardB + towardC > 1) continue;
        found.push_back({static_cast<std::uint32_t>(i * across_ + j),
                         spacing_ * (p[0][axis_] + towardB * b[axis_] + towardC * c[axis_]),
                         static_cast<std::uint32_t>(t)});
      }
    return tried;
  }

  int axis_, u_, w_;
  double spacing_;
  Vec3 low_;
  std::int64_t along_ = 0, across_ = 0;
};

Vec3 normalOf(const Mesh& mesh, std::uint32_t triangle) {
  const auto& t = mesh.triangles[triangle];
  const auto at = [&](int k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
  return (at(1) - at(0)).cross(at(2) - at(0)).normalized();
}

constexpr double kNeither = std::numeric_limits<double>::infinity();

// The voxels that the chords of one line want at most [m].
void addWants(const std::vector<double>& chords, std::vector<double>& wants) {
  for (std::size_t k = 0; k < chords.size(); ++k) {
    const double before = k > 0 ? chords[k - 1] : kNeither,
                 after = k + 1 < chords.size() ? chords[k + 1] : kNeither;
    const double rib = (chords[k] + std::min(before, after)) / 2;
    wants.push_back(std::min(chords[k] / kVoxelsInWall, rib / kVoxelsInRib));
  }
}

// The same for all lines of an axis. Chords that are neither walls nor grooves want nothing.
void addWants(const Mesh& mesh, std::vector<LineCrossing>& found, double shortest,
              std::vector<double>& wants) {
  std::sort(found.begin(), found.end(), [](const LineCrossing& a, const LineCrossing& b) {
    return std::tie(a.line, a.at, a.triangle) < std::tie(b.line, b.at, b.triangle);
  });
  std::vector<double> chords;
  for (std::size_t k = 1; k <= found.size(); ++k) {
    const LineCrossing& from = found[k - 1];
    if (k == found.size() || found[k].line != from.line) {
      addWants(chords, wants);
      chords.clear();
      continue;
    }
    const double length = found[k].at - from.at;
    if (length < shortest) continue;
    const Vec3 normal = normalOf(mesh, from.triangle);
    const bool opposed = normal.dot(normalOf(mesh, found[k].triangle)) < kOpposed;
    chords.push_back(opposed ? length : kNeither);
  }
}

// The voxel that a tenth of a mesh's chords still want finer [m].
double wantedVoxel(const Mesh& mesh, const Eigen::AlignedBox3d& bounds, double spacing) {
  std::vector<double> wants;
  std::vector<LineCrossing> found;
  for (int axis = 0; axis < 3; ++axis) {
    found.clear();
    if (!Lines(bounds, axis, spacing).cross(mesh, found)) return spacing;
    addWants(mesh, found, kNoChord * spacing, wants);
  }
  if (wants.empty()) return spacing;
  const auto tenth = wants.begin() + static_cast<std::ptrdiff_t>(kShareOfChords *
                                                                 static_cast<double>(wants.size()));
  std::nth_element(wants.begin(), tenth, wants.end());
  return *tenth;
}

}  // namespace

double suggestedVoxel(const Eigen::AlignedBox3d& bounds) {
  return bounds.isEmpty() ? 0 : kOfDiagonal * bounds.diagonal().norm();
}

double suggestedVoxel(const Mesh& mesh) {
  validate(mesh);
  Eigen::AlignedBox3d bounds;
  for (const Vec3& vertex : mesh.vertices) bounds.extend(vertex);
  const double coarsest = suggestedVoxel(bounds);
  if (!(coarsest > 0) || !std::isfinite(coarsest))
    throw std::invalid_argument(
        "suggestedVoxel: the mesh has no size to take a voxel from; check its vertices");
  const double least = kLeastOfDiagonal / kOfDiagonal * coarsest;
  return std::clamp(wantedVoxel(mesh, bounds, coarsest), least, coarsest);
}

}  // namespace cloudcontact
