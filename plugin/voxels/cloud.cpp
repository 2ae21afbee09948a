// Clouds: access, counts and mass properties. See cloud.h.
#include <cloudcontact/voxels/cloud.h>

#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "base/grid_index.h"

namespace cloudcontact {

namespace {

// Moments of a brick: sums of coverage [1/255] times powers of the voxels' indices. Integers, so
// exact; 512 * 255 * 49 fits in 32 bits.
struct BrickMoments {
  std::int64_t mass = 0;
  std::int64_t first[3] = {0, 0, 0};
  std::int64_t second[6] = {0, 0, 0, 0, 0, 0};  // xx yy zz xy yz zx
};

template <typename CoverageAt>
BrickMoments momentsOf(CoverageAt&& coverageAt) {
  BrickMoments m;
  int v = 0;
  for (int z = 0; z < kBrickEdge; ++z)
    for (int y = 0; y < kBrickEdge; ++y)
      for (int x = 0; x < kBrickEdge; ++x, ++v) {
        const std::int64_t c = coverageAt(v);
        m.mass += c;
        m.first[0] += c * x, m.first[1] += c * y, m.first[2] += c * z;
        m.second[0] += c * x * x, m.second[1] += c * y * y, m.second[2] += c * z * z;
        m.second[3] += c * x * y, m.second[4] += c * y * z, m.second[5] += c * z * x;
      }
  return m;
}

// Moments of the cloud [voxels], about a point near its middle: a distant point would cost digits.
struct CloudMoments {
  double mass = 0;
  Vec3 first = Vec3::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();

  // `corner`: center of the brick's first voxel, from the chosen point.
  void add(const BrickMoments& b, const Vec3& corner) {
    const double m = b.mass;
    const Vec3 f(static_cast<double>(b.first[0]), static_cast<double>(b.first[1]),
                 static_cast<double>(b.first[2]));
    Eigen::Matrix3d s;
    const auto d = [&](int i) { return static_cast<double>(b.second[i]); };
    s << d(0), d(3), d(5), d(3), d(1), d(4), d(5), d(4), d(2);
    mass += m;
    first += f + m * corner;
    second += s + corner * f.transpose() + f * corner.transpose() + m * corner * corner.transpose();
  }
  // Moves what was added at `place`.
  void shift(double m, const Vec3& place, const Vec3& by) {
    first += m * by;
    second += m * (place * by.transpose() + by * place.transpose() + by * by.transpose());
  }
};

// The center of the material of a surface voxel, from the voxel's center [voxels]. It lies toward
// the fuller neighbors. A face across the voxel at fraction f leaves material whose middle is (1 -
// f) / 2 from the center. For oblique faces that is at most 2 % too little, summed over all
// positions of the face: the sum is the variance of a cube, 1/12, in every direction. Without this
// shift the inertia of a body of radius R is too large by about (h / R)^2 / 2.
Vec3 shiftOfMaterial(const Cloud& cloud, int x, int y, int z, int coverage) {
  const Vec3 slope(cloud.coverage(x + 1, y, z) - cloud.coverage(x - 1, y, z),
                   cloud.coverage(x, y + 1, z) - cloud.coverage(x, y - 1, z),
                   cloud.coverage(x, y, z + 1) - cloud.coverage(x, y, z - 1));
  const double steep = slope.norm();
  return steep > 0 ? Vec3((0.5 - 0.5 * coverage / 255) / steep * slope) : Vec3(Vec3::Zero());
}

template <typename Visit>
void forEachFullBrick(const Cloud::Voxels& voxels, Visit&& visit) {
  std::size_t entry = 0;
  for (int z = 0; z < voxels.bricks[2]; ++z)
    for (int y = 0; y < voxels.bricks[1]; ++y)
      for (int x = 0; x < voxels.bricks[0]; ++x, ++entry)
        if (const std::int32_t b = voxels.table[entry]; b != kEmptyBrick) visit(b, x, y, z);
}

void validateTable(const Cloud::Voxels& voxels) {
  std::size_t expected = 1;
  for (int k = 0; k < 3; ++k) {
    if (voxels.bricks[k] < 0) throw std::invalid_argument("cloud: bricks must not be negative");
    const std::size_t n = voxels.bricks[k];
    if (n != 0 && expected > voxels.table.max_size() / n)
      throw std::invalid_argument("cloud: bricks are more than can be addressed");
    expected *= n;
  }
  if (voxels.table.size() != expected)
    throw std::invalid_argument("cloud: table has " + std::to_string(voxels.table.size()) +
                                " entries, but bricks require " + std::to_string(expected));
  for (const std::int32_t b : voxels.table)
    if (b < kSolidBrick || (b >= 0 && static_cast<std::size_t>(b) >= voxels.coverage.size()))
      throw std::invalid_argument("cloud: table names brick " + std::to_string(b) +
                                  ", but there are " + std::to_string(voxels.coverage.size()));
}

void validateMaterials(const Cloud::Voxels& voxels) {
  if (voxels.materials.empty() && voxels.materialTable.empty() && voxels.material.empty()) return;
  const auto count = static_cast<std::int64_t>(voxels.materials.size());
  if (count > 256) throw std::invalid_argument("cloud: more than 256 materials");
  for (const std::string& name : voxels.materials)
    if (name.find('\0') != std::string::npos)
      throw std::invalid_argument("cloud: a material's name has a zero in it");
  if (voxels.material.size() > voxels.table.size())
    throw std::invalid_argument("cloud: more bricks have materials than there are");
  if (voxels.materialTable.size() != voxels.table.size())
    throw std::invalid_argument("cloud: the table of materials has another size than the bricks'");
  for (const std::int32_t m : voxels.materialTable)
    if (m < -count || m >= static_cast<std::int64_t>(voxels.material.size()))
      throw std::invalid_argument("cloud: a brick names a material that is not there");
  for (const BrickMaterial& brick : voxels.material)
    for (const std::uint8_t m : brick)
      if (m >= count) throw std::invalid_argument("cloud: a voxel names no material of the cloud");
}

// A voxel's brick and its cell in the brick; empty outside the grid.
struct VoxelPlace {
  std::size_t entry, inBrick;
};
std::optional<VoxelPlace> placeOf(const Cloud::Voxels* voxels, int x, int y, int z) {
  if (!voxels || !insideGrid(x >> 3, y >> 3, z >> 3, voxels->bricks)) return {};
  return VoxelPlace{brickIndex(x, y, z, voxels->bricks),
                    static_cast<std::size_t>(cellIndex(x, y, z))};
}

}  // namespace

Cloud::Cloud(double voxelSize, const Vec3& origin, std::shared_ptr<const Voxels> voxels)
    : voxelSize_(voxelSize), origin_(origin), voxels_(std::move(voxels)) {
  if (!(voxelSize > 0) || !std::isfinite(voxelSize))
    throw std::invalid_argument("cloud: voxelSize must be positive and finite [m]");
  if (!origin.allFinite()) throw std::invalid_argument("cloud: origin must be finite [m]");
  if (!voxels_) throw std::invalid_argument("cloud: voxels are missing");
  validateTable(*voxels_);
  validateMaterials(*voxels_);
}

std::uint8_t Cloud::coverage(int x, int y, int z) const {
  const auto place = placeOf(voxels_.get(), x, y, z);
  if (!place) return 0;
  const std::int32_t b = voxels_->table[place->entry];
  if (b < 0) return b == kSolidBrick ? 255 : 0;
  return voxels_->coverage[b][place->inBrick];
}

const std::vector<std::string>& Cloud::materials() const {
  static const std::vector<std::string> kNone;
  return voxels_ ? voxels_->materials : kNone;
}

std::uint8_t Cloud::material(int x, int y, int z) const {
  const auto place = placeOf(voxels_.get(), x, y, z);
  if (!place || voxels_->materialTable.empty()) return 0;
  const std::int32_t m = voxels_->materialTable[place->entry];
  if (m < 0) return static_cast<std::uint8_t>(-1 - m);
  return voxels_->material[m][place->inBrick];
}

Vec3 Cloud::center(int x, int y, int z) const {
  return origin_ + voxelSize_ * Vec3(x + 0.5, y + 0.5, z + 0.5);
}

Cloud Cloud::translated(const Vec3& shift) const {
  if (!shift.allFinite()) throw std::invalid_argument("cloud: shift must be finite [m]");
  Cloud moved = *this;
  moved.origin_ += shift;
  return moved;
}

Cloud Cloud::scaled(double factor) const {
  if (!(factor > 0) || !std::isfinite(factor))
    throw std::invalid_argument("cloud: the factor of a scaling must be positive and finite");
  Cloud larger = *this;
  larger.voxelSize_ *= factor;
  larger.origin_ *= factor;
  return larger;
}

VoxelCounts Cloud::counts() const {
  VoxelCounts counts;
  if (empty()) return counts;
  forEachFullBrick(*voxels_, [&](std::int32_t b, int, int, int) {
    if (b == kSolidBrick) {
      counts.inside += kBrickVoxels;
      return;
    }
    for (const std::uint8_t c : voxels_->coverage[b]) {
      counts.inside += c == 255;
      counts.interface += c > 0 && c < 255;
    }
  });
  return counts;
}

MassProperties Cloud::massProperties() const {
  MassProperties result;
  if (empty()) return result;
  // First all voxels at their centers, exactly; then the shifts of the surface voxels.
  const Vec3 middle = 0.5 * size().cast<double>();
  const BrickMoments solid = momentsOf([](int) { return 255; });
  CloudMoments sum;
  forEachFullBrick(*voxels_, [&](std::int32_t b, int x, int y, int z) {
    const Vec3 corner = kBrickEdge * Vec3(x, y, z) + Vec3::Constant(0.5) - middle;
    if (b == kSolidBrick) return sum.add(solid, corner);
    const BrickCoverage& c = voxels_->coverage[b];
    sum.add(momentsOf([&](int v) { return c[v]; }), corner);
    for (int v = 0; v < kBrickVoxels; ++v) {
      const int m = c[v];
      if (m == 0 || m == 255) continue;
      const Vec3 inBrick = cellOffset(v).cast<double>();
      const Eigen::Vector3i at = kBrickEdge * Eigen::Vector3i(x, y, z) + cellOffset(v);
      sum.shift(m, corner + inBrick, shiftOfMaterial(*this, at[0], at[1], at[2], m));
    }
  });
  if (sum.mass == 0) return result;
  const double h = voxelSize_;
  const Vec3 mean = sum.first / sum.mass;
  // Second moments about the center of mass; a voxel's own is a twelfth of its edge squared.
  const Eigen::Matrix3d second = (sum.second - sum.mass * mean * mean.transpose() +
                                  sum.mass / 12 * Eigen::Matrix3d::Identity()) /
                                 255;
  result.volume = result.mass = sum.mass / 255 * h * h * h;
  result.centerOfMass = origin_ + h * (mean + middle);
  result.inertia = std::pow(h, 5) * (second.trace() * Eigen::Matrix3d::Identity() - second);
  return result;
}

std::size_t Cloud::bytes() const {
  if (!voxels_) return 0;
  return sizeof(Voxels) + voxels_->table.capacity() * sizeof(std::int32_t) +
         voxels_->coverage.capacity() * sizeof(BrickCoverage) +
         voxels_->materialTable.capacity() * sizeof(std::int32_t) +
         voxels_->material.capacity() * sizeof(BrickMaterial);
}

}  // namespace cloudcontact
