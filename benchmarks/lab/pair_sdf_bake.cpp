// Bullet reads the format of the library Discregrid (its .cdf files; btMiniSDF::load): the domain,
// the cells along each axis, then for each field (here one) the values at the nodes, 32 node
// numbers a cell, and which cell stands at each place of the grid. A cell's 32 nodes are its
// corners and two on each edge, at a third and two thirds: a cubic interpolation without inner
// nodes. Cells share the nodes of their common edges, so nodes are named by their place on the
// lattice of thirds of cells.
#include "lab/pair_sdf_bake.h"

#include <BulletCollision/CollisionShapes/btSdfCollisionShape.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>

namespace cloudcontact::program::lab {

namespace {

using Place = std::array<int, 3>;  // on the lattice of thirds

// Where a cell's nodes lie in it, in thirds, in the order of btMiniSDF::shape_function_: corners,
// then edges along x, y and z, of which the place along the next axis (of x, y, z, x) changes
// slowest.
std::array<Place, 32> nodePlaces() {
  std::array<Place, 32> places{};
  std::size_t k = 0;
  for (int corner = 0; corner < 8; ++corner)
    places[k++] = {corner & 1 ? 3 : 0, corner & 2 ? 3 : 0, corner & 4 ? 3 : 0};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (int slow = 0; slow < 2; ++slow)
      for (int fast = 0; fast < 2; ++fast)
        for (int third = 1; third <= 2; ++third) {
          Place& place = places[k++];
          place[axis] = third;
          place[(axis + 1) % 3] = 3 * slow;
          place[(axis + 2) % 3] = 3 * fast;
        }
  return places;
}

class SdfData {
 public:
  SdfData(const Eigen::AlignedBox3d& domain, double cell) : domain_(domain) {
    for (int k = 0; k < 3; ++k)
      count_[k] = std::clamp(int(std::ceil(domain.sizes()[k] / cell)), 1, kMaxSdfCells);
    cell_ = domain.sizes().cwiseQuotient(count_.cast<double>());
  }

  std::vector<char> bake(const std::function<double(const Vec3&)>& distance) {
    const std::vector<std::uint32_t> cells = numberNodes();
    const std::uint64_t cellCount = cells.size() / 32, fields = 1;
    for (int k = 0; k < 3; ++k) write(domain_.min()[k]);
    for (int k = 0; k < 3; ++k) write(domain_.max()[k]);
    for (int k = 0; k < 3; ++k) write(std::uint32_t(count_[k]));
    for (int k = 0; k < 3; ++k) write(cell_[k]);
    for (int k = 0; k < 3; ++k) write(1 / cell_[k]);
    write(cellCount);
    write(fields);
    write(fields);
    write(std::uint64_t(nodes_.size()));
    for (const Place& p : nodes_)
      write(distance(domain_.min() + cell_.cwiseProduct(Vec3(p[0], p[1], p[2]) / 3)));
    write(fields);
    write(cellCount);
    for (const std::uint32_t node : cells) write(node);
    write(fields);
    write(cellCount);
    for (std::uint32_t k = 0; k < cellCount; ++k) write(k);
    return std::move(bytes_);
  }

 private:
  template <class T>
  void write(const T& value) {
    const char* begin = reinterpret_cast<const char*>(&value);
    bytes_.insert(bytes_.end(), begin, begin + sizeof value);
  }

  // The numbers of each cell's 32 nodes; nodes_ gets their places.
  std::vector<std::uint32_t> numberNodes() {
    constexpr std::uint32_t none = UINT32_MAX;
    const Eigen::Matrix<std::size_t, 3, 1> lattice =
        (3 * count_ + Eigen::Vector3i::Ones()).cast<std::size_t>();
    std::vector<std::uint32_t> numberAt(lattice.prod(), none);
    const std::array<Place, 32> places = nodePlaces();
    std::vector<std::uint32_t> cells;
    for (int z = 0; z < count_[2]; ++z)
      for (int y = 0; y < count_[1]; ++y)
        for (int x = 0; x < count_[0]; ++x)
          for (const Place& p : places) {
            const Place at = {3 * x + p[0], 3 * y + p[1], 3 * z + p[2]};
            std::uint32_t& number =
                numberAt[(std::size_t(at[2]) * lattice[1] + std::size_t(at[1])) * lattice[0] +
                         std::size_t(at[0])];
            if (number == none) {
              number = std::uint32_t(nodes_.size());
              nodes_.push_back(at);
            }
            cells.push_back(number);
          }
    return cells;
  }

  Eigen::AlignedBox3d domain_;
  Eigen::Vector3i count_;
  Vec3 cell_;
  std::vector<Place> nodes_;
  std::vector<char> bytes_;
};

}  // namespace

BulletShape bakedSdfShape(const std::function<double(const Vec3&)>& distance,
                        const Eigen::AlignedBox3d& domain, double cell) {
  const std::vector<char> bytes = SdfData(domain, cell).bake(distance);
  auto shape = std::make_shared<btSdfCollisionShape>();
  if (!shape->initializeSDF(bytes.data(), int(bytes.size())))
    throw std::runtime_error("btSdfCollisionShape does not take the distance field");
  return {{}, shape};
}

}  // namespace cloudcontact::program::lab
