// Concave bodies: what this project is for. The force on B is along +z or -x.
#include <cmath>
#include <numbers>

#include "lab/case_parts.h"
#include "lab/oracle.h"
#include "lab/solids.h"
#include "lab/turned_mesh.h"
#include "scene/generated_mesh.h"

namespace cloudcontact::program::lab {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSize = 0.01;  // [m]

Truth along(const Vec3& direction, const Vec3& centre) {
  return {direction, 0.0, centre, {}};
}

Instance stackedTori(std::uint64_t seed) {
  Random random(seed);
  LabBody a = torusBody(random, 2.5 * kSize, kSize), b = torusBody(random, 2.5 * kSize, kSize);
  return {a, b,
          pressed(
              depthsOf(kSize), [](double d) { return at(0, 0, 2 * kSize - d); },
              along(Vec3::UnitZ(), Vec3::Zero()))};
}

// Two rings of a chain, pulled apart: the tubes cross inside.
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
  // The key's flat is as wide as itself; the socket's is wider by the gap.
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
    // From the hole's lower end, where the peg's chamfer is, to its own chamfer at the top.
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

// Pulled along the axis until the flanks press. Turning by an angle and rising by its share of the
// lead changes nothing, so no work is done by it: torque = -force lead / 2 pi, without friction. A
// nut of two turns and a half is pressed sideways too, by the half turn and the chamfers: that part
// is quadrature's.
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
    known.deepest = std::cos(flank);  // of what it is pulled; the lead's share is 0.3 %
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

std::vector<LabCase> allCases() {
  std::vector<LabCase> cases = convexCases();
  for (const auto& more : {concaveCases(), grooveCases(), deepCases(), randomCases()})
    cases.insert(cases.end(), more.begin(), more.end());
  return cases;
}

}  // namespace cloudcontact::program::lab
