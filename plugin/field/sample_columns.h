// Samples of a surface, a column a quantity, so that many are looked up side by side.
#pragma once

#include <cloudcontact/field/surface_field.h>

#include <vector>

namespace cloudcontact {

struct SampleColumns {
  std::vector<float> x, y, z;     // [voxels], grid frame
  std::vector<float> nx, ny, nz;  // outward unit
  std::vector<float> area, width;

  std::size_t size() const { return x.size(); }
  std::size_t bytes() const { return 8 * sizeof(float) * size(); }
  SurfaceSample operator[](std::size_t k) const {
    return {{x[k], y[k], z[k]}, {nx[k], ny[k], nz[k]}, area[k], width[k]};
  }
  void append(const SampleColumns& from, std::size_t first, std::size_t count) {
    const auto add = [&](std::vector<float>& to, const std::vector<float>& source) {
      const auto begin = source.begin() + static_cast<std::ptrdiff_t>(first);
      to.insert(to.end(), begin, begin + static_cast<std::ptrdiff_t>(count));
    };
    add(x, from.x), add(y, from.y), add(z, from.z);
    add(nx, from.nx), add(ny, from.ny), add(nz, from.nz);
    add(area, from.area), add(width, from.width);
  }
  // Room for what the other has room for.
  void fit(const SampleColumns& other) {
    for (auto* column : {&x, &y, &z, &nx, &ny, &nz, &area, &width})
      column->reserve(other.x.capacity());
  }
  void clear() {
    for (auto* column : {&x, &y, &z, &nx, &ny, &nz, &area, &width}) column->clear();
  }
  void push_back(const SurfaceSample& s) {
    x.push_back(s.position[0]);
    y.push_back(s.position[1]);
    z.push_back(s.position[2]);
    nx.push_back(s.normal[0]);
    ny.push_back(s.normal[1]);
    nz.push_back(s.normal[2]);
    area.push_back(s.area);
    width.push_back(s.width);
  }
};

}  // namespace cloudcontact
