// Concave bodies: rings, holes, threads, pegs, plates, and bodies deep in each other. The force on
// B is along +z or -x.
#include <cmath>
#include <numbers>

#include "lab/case_bodies.h"
#include "lab/lab_meshes.h"
#include "lab/oracle.h"
#include "scene/generated_mesh.h"

namespace cloudcontact::program::lab {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSize = 0.01;  // [m]

Truth along(const Vec3& direction, const Vec3& center) {
  return {direction, 0.0, center, {}};
}

Instance stackedTori(std::uint64_t seed) {
  Random random(seed);
  LabBody a = torusBody(random, 2.5 * kSize, kSize), b = torusBody(random, 2.5 * kSize, kSize);
  return {a, b,
          pressed(
              depthsOf(kSize), [](double d) { return at(0, 0, 2 * kSize - d); },
              along(Vec3::UnitZ(), Vec3::Zero()))};
}

// Two links of a chain, pulled apart: the tubes cross inside.
Instance chainLinks(std::uint64_t seed) {
  Random random(seed);
  const double ring = 2.5 * kSize;
  LabBody a = torusBody(random, ring, kSize), b = torusBody(random, ring, kSize);
  return {a, b,
          pressed(
              depthsOf(kSize),
              [=](double d) { return at(2 * ring - 2 * kSize + d, 0, 0, turnX(kPi / 2)); },
              along(-Vec3::UnitX(), Vec3::Zero()))};
}

Instance tubeOverRod(std::uint64_t seed) {
  Random random(seed);
  const double gap = 0.05 * kSize, turn = random.uniform(0, 1);
  LabBody a = primitiveBody("rod", Cylinder{kSize, 2 * kSize}, random);
  LabBody b = meshBody(
      "tube",
      [=](double tolerance) {
        const Outline inner = circle(kSize + gap, tolerance);
        const Outline outer = polygon(int(inner.size()), 1.5 * kSize);
        return moved(tube(inner, outer, -kSize, kSize), {turnZ(turn), Vec3::Zero()});
      },
      random);
  return {a, b,
          pressed(
              depthsOf(kSize), [=](double d) { return at(gap + d, 0, 0.3 * kSize); },
              along(-Vec3::UnitX(), {0, 0, 0.3 * kSize}))};
}

Instance hexKey(std::uint64_t seed) {
  Random random(seed);
  const double gap = 0.03 * kSize;
  LabBody a = meshBody(
      "socket",
      [=](double) {
        return tube(polygon(6, kSize + gap, -kPi / 6), polygon(6, 1.8 * kSize, -kPi / 6), -kSize,
                    kSize);
      },
      random);
  LabBody b = meshBody(
      "key", [](double) { return prism(polygon(6, kSize, -kPi / 6), -0.7 * kSize, 3 * kSize); },
      random, true);
  // The key's flat is narrower than the socket's by the gap.
  return {a, b,
          pressed(
              depthsOf(kSize), [=](double d) { return at(gap + d, 0, 0); },
              along(-Vec3::UnitX(), {0, 0, 0.15 * kSize}))};
}

constexpr double kPeg = 4e-3;  // [m] radius

std::function<Instance(std::uint64_t)> pegInHole(double clearance) {
  return [=](std::uint64_t seed) {
    Random random(seed);
    LabBody a = meshBody(
        "hole",
        [=](double tolerance) {
          const int n = (circleSegments(kPeg, tolerance) + 7) / 8 * 8;
          return holeMesh(kPeg + clearance, 5 * kPeg, 2 * kPeg, 0.1 * kPeg, n);
        },
        random);
    LabBody b = meshBody(
        "peg",
        [](double tolerance) {
          const int n = (circleSegments(kPeg, tolerance) + 7) / 8 * 8;
          return pegMesh(kPeg, 3 * kPeg, 0.1 * kPeg, n);
        },
        random, true);
    // The contact spans from the hole's lower end, plus the chamfer, to its chamfer at the top.
    const double low = 0.5 * kPeg + 0.1 * kPeg, high = 2 * kPeg - 0.1 * kPeg;
    return Instance{a, b,
                    pressed(
                        depthsOf(kPeg), [=](double d) { return at(clearance + d, 0, 0.5 * kPeg); },
                        along(-Vec3::UnitX(), {0, 0, (low + high) / 2}))};
  };
}

Instance bowlInBowl(std::uint64_t seed) {
  Random random(seed);
  const double gap = 0.2 * kSize;
  LabBody a = meshBody(
      "bowl",
      [=](double t) { return bowlMesh(kSize + gap, 1.6 * kSize, circleSegments(1.6 * kSize, t)); },
      random);
  LabBody b = meshBody(
      "bowl", [](double t) { return bowlMesh(0.6 * kSize, kSize, circleSegments(kSize, t)); },
      random);
  return {a, b,
          pressed(
              depthsOf(kSize), [=](double d) { return at(0, 0, -gap - d); },
              along(Vec3::UnitZ(), Vec3::Zero()))};
}

std::function<Instance(std::uint64_t)> sphereOnPlate(double thickness) {
  return [=](std::uint64_t seed) {
    Random random(seed);
    LabBody a = primitiveBody("plate", Box{Vec3(1.5 * kSize, 1.5 * kSize, thickness / 2)}, random);
    LabBody b = primitiveBody("sphere", Sphere{kSize}, random);
    return Instance{a, b,
                    pressed(
                        depthsOf(kSize, 0.4 * thickness),
                        [=](double d) { return at(0, 0, thickness / 2 + kSize - d); },
                        along(Vec3::UnitZ(), Vec3::Zero()))};
  };
}

Thread boltThread(bool leftHanded, int starts, double tolerance) {
  Thread thread;
  thread.majorDiameter = 8e-3, thread.pitch = 2e-3, thread.starts = starts;
  thread.leftHanded = leftHanded, thread.clearance = 0.05e-3;
  thread.segments = std::clamp((circleSegments(4e-3, tolerance) + 23) / 24 * 24, 48, 384);
  return thread;
}

// The nut is pulled along the axis until the flanks press. A helical motion leaves the contact
// unchanged and does no work, so without friction torque = -force * lead / (2 pi). A nut of two and
// a half turns is also pushed sideways, by the half turn and the chamfers; quadrature supplies that
// part.
std::function<Instance(std::uint64_t)> nutOnBolt(bool leftHanded, int starts) {
  const auto bolt = [=](double t) { return boltMesh(boltThread(leftHanded, starts, t), 12e-3); };
  const auto nut = [=](double t) {
    return nutMesh(boltThread(leftHanded, starts, t), 5e-3, 13e-3);
  };
  const Thread thread = boltThread(leftHanded, starts, 1e-6);
  const double flank = thread.flankAngle / 2;
  const double start = 2 * thread.pitch + 2 * thread.clearance * std::tan(flank);
  const auto truth = once<Truth>([=] {
    const OracleForce fair =
        foundationForce(bolt(2e-6), nut(2e-6), at(0, 0, start + kDepths[1] * 4e-3), 0.1e-3);
    Truth known{fair.force.normalized(), {}, Vec3::Zero(), {}};
    known.torquePerForce = (leftHanded ? 1 : -1) * thread.lead() / (2 * kPi);
    known.deepest = std::cos(flank);  // times the pull; the lead changes it by 0.3 %
    return known;
  });
  return [=](std::uint64_t seed) {
    Random random(seed);
    LabBody a = meshBody("bolt", bolt, random), b = meshBody("nut", nut, random);
    return Instance{a, b,
                    pressed(
                        depthsOf(4e-3), [=](double d) { return at(0, 0, start + d); }, truth())};
  };
}

// Concave bodies 2, 5 and 10 voxels (of size / 32) deep in each other: deeper than the fields' band
// and than most methods are made for. The force on B is along z by symmetry, or because the forces
// on a prism's sides cancel. Its line of action depends on the law.
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

// An L-shaped prism stands on its base.
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

std::vector<LabCase> concaveCases() {
  std::vector<LabCase> cases = {
      {"rings", "torus on torus", false, true, kSize, true, stackedTori},
      {"rings", "chain links", false, true, kSize, true, chainLinks},
      {"holes", "tube over a rod", false, true, kSize, true, tubeOverRod},
      {"holes", "hex key in its socket", false, false, kSize, true, hexKey},
      {"holes", "bowl in a bowl", false, true, kSize, false, bowlInBowl},
      {"threads", "nut on its bolt", false, false, 4e-3, true, nutOnBolt(false, 1)},
      {"threads", "left-handed", false, false, 4e-3, false, nutOnBolt(true, 1)},
      {"threads", "two starts", false, false, 4e-3, false, nutOnBolt(false, 2)}};
  for (const double clearance : {1e-3, 0.5e-3, 0.2e-3, 0.1e-3, 0.05e-3}) {
    char name[64];
    std::snprintf(name, sizeof name, "peg in a hole, clearance %g mm", 1e3 * clearance);
    cases.push_back({"pegs", name, false, false, kPeg, clearance == 0.1e-3, pegInHole(clearance)});
  }
  for (const double voxels : {0.5, 1.0, 2.0, 3.0}) {
    char name[64];
    std::snprintf(name, sizeof name, "plate of %g voxel%s of size / 32", voxels,
                  voxels == 1 ? "" : "s");
    const double thickness = voxels * kSize / 32;
    cases.push_back({"plates", name, true, true, kSize, voxels == 2, sphereOnPlate(thickness)});
  }
  return cases;
}

std::vector<LabCase> deepCases() {
  return {{"deep, concave", "torus deep in a plate", false, false, kSize, true, torusInPlate},
          {"deep, concave", "torus deep in a torus", false, false, kSize, false, torusInTorus},
          {"deep, concave", "L-shape deep in a block", false, false, kSize, false, angleInBlock}};
}

}  // namespace cloudcontact::program::lab
