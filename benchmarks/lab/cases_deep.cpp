// Concave bodies that lie in each other by 2, 5 and 10 voxels of size / 32: deeper than the fields'
// band, and than what most methods were made for. By symmetry, or since a prism's sides cancel, the
// force on B is along z; where it acts hangs on the law.
#include "lab/case_parts.h"
#include "lab/solids.h"

namespace cloudcontact::program::lab {
namespace {

constexpr double kSize = 0.01;  // [m]

std::vector<double> deep() {
  return {2 * kSize / 32, 5 * kSize / 32, 10 * kSize / 32};
}
Truth upward() {
  return {Vec3::UnitZ(), 0.0, {}, {}};
}

Instance torusInPlate(std::uint64_t seed) {
  Random random(seed);
  LabBody a = primitiveBody("plate", Box{Vec3(4.5, 4.5, 1) * kSize}, random);
  LabBody b = torusBody(random, 2.5 * kSize, kSize);
  return {a, b,
          pressed(
              deep(), [](double d) { return at(0, 0, 2 * kSize - d); }, upward())};
}

Instance torusInTorus(std::uint64_t seed) {
  Random random(seed);
  LabBody a = torusBody(random, 2.5 * kSize, kSize), b = torusBody(random, 2.5 * kSize, kSize);
  return {a, b,
          pressed(
              deep(), [](double d) { return at(0, 0, 2 * kSize - d); }, upward())};
}

// Standing on the face of which it is a prism.
Instance angleInBlock(std::uint64_t seed) {
  Random random(seed);
  LabBody a = primitiveBody("block", Box{Vec3(2.5, 2.5, 1) * kSize}, random);
  const Outline section = {{-1, -1}, {1, -1}, {1, -0.2}, {-0.2, -0.2}, {-0.2, 1}, {-1, 1}};
  LabBody b = meshBody(
      "L-shape",
      [=](double) {
        Outline scaled = section;
        for (auto& p : scaled) p *= 1.5 * kSize;
        return prism(scaled, 0, 1.5 * kSize);
      },
      random);
  return {a, b,
          pressed(
              deep(), [](double d) { return at(0, 0, kSize - d, turnZ(0.5)); }, upward())};
}

}  // namespace

std::vector<LabCase> deepCases() {
  return {{"deep, concave", "torus deep in a plate", false, false, kSize, true, torusInPlate},
          {"deep, concave", "torus deep in a torus", false, false, kSize, false, torusInTorus},
          {"deep, concave", "L-shape deep in a block", false, false, kSize, false, angleInBlock}};
}

}  // namespace cloudcontact::program::lab
