// Concave bodies: what this project is for. The force on B is along +z or -x.
#include <cmath>
#include <numbers>

#include "generated_mesh.h"
#include "lab/case_parts.h"
#include "lab/oracle.h"
#include "lab/solids.h"
#include "lab/turned_mesh.h"

namespace cloudcontact::program::lab {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSize = 0.01;  // [m]

Truth along(const Vec3& direction, const Vec3& centre) {
  return {direction, 0.0, centre, {}};
}
// Touching in two places or more: by symmetry the direction is known, how hard is the law's to say.
Truth towards(const Vec3& direction, const Vec3& centre) {
  return {direction, {}, centre, {}};
}

// Turned about its axis by any angle: where facets mirror each other, errors of methods that take
// triangles would cancel.
LabBody torusBody(Random& random, double ring, double wire) {
  const Pose turned{turnZ(random.uniform(0, 2 * kPi)), Vec3::Zero()};
  return meshBody(
      "torus", [=](double tolerance) { return moved(torus(ring, wire, tolerance), turned); },
      random);
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

// The groove's flanks at 45 degrees, a capsule lying in it.
Outline grooved(double half, double depth) {
  return {{-half, -half}, {half, -half}, {half, 0}, {depth, 0},
          {0, -depth},    {-depth, 0},   {-half, 0}};
}
LabBody groovedBlock(Random& random, double depth) {
  return meshBody(
      "block with a V groove",
      [=](double) {
        return moved(prism(grooved(2.5 * kSize, depth), -2 * kSize, 2 * kSize),
                     {turnX(kPi / 2), Vec3::Zero()});
      },
      random);
}

Instance capsuleInGroove(std::uint64_t seed) {
  Random random(seed);
  LabBody a = groovedBlock(random, 1.8 * kSize);
  LabBody b = primitiveBody("capsule", CapsuleShape{kSize, 0.8 * kSize}, random);
  const double up = -1.8 * kSize + std::numbers::sqrt2 * kSize;  // touching both flanks
  return {a, b,
          pressed(
              depthsOf(kSize),
              [=](double d) { return at(0, 0, up - std::numbers::sqrt2 * d, turnX(kPi / 2)); },
              towards(Vec3::UnitZ(), Vec3::Zero()))};
}

// A wedge of half angle 30 degrees, its edge in the groove's bottom.
Instance spikeInCrack(std::uint64_t seed) {
  Random random(seed);
  LabBody a = groovedBlock(random, 1.8 * kSize);
  const Outline wedge = {{0, 0}, {kSize, std::sqrt(3.0) * kSize}, {-kSize, std::sqrt(3.0) * kSize}};
  LabBody b = meshBody(
      "wedge",
      [=](double) {
        return moved(prism(wedge, -kSize, kSize), {turnX(kPi / 2), Vec3::Zero()});
      },
      random, true);
  return {a, b,
          pressed(
              depthsOf(kSize), [=](double d) { return at(0, 0, -1.8 * kSize - d); },
              towards(Vec3::UnitZ(), Vec3::Zero()))};
}

Instance tubeOverRod(std::uint64_t seed) {
  Random random(seed);
  const double gap = 0.05 * kSize, turn = random.uniform(0, 1);
  LabBody a = primitiveBody("rod", CylinderShape{kSize, 2 * kSize}, random);
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
    LabBody a =
        primitiveBody("plate", BoxShape{Vec3(1.5 * kSize, 1.5 * kSize, thickness / 2)}, random);
    LabBody b = primitiveBody("sphere", SphereShape{kSize}, random);
    return Instance{a, b,
                    pressed(
                        depthsOf(kSize, 0.4 * thickness),
                        [=](double d) { return at(0, 0, thickness / 2 + kSize - d); },
                        along(Vec3::UnitZ(), Vec3::Zero()))};
  };
}

// Pulled along the axis until the flanks press. Turning by an angle and rising by its share of the
// lead changes nothing, so no work is done by it: torque = -force lead / 2 pi, without friction.
std::function<Instance(std::uint64_t)> nutOnBolt(bool leftHanded, int starts) {
  return [=](std::uint64_t seed) {
    Random random(seed);
    Thread thread;
    thread.majorDiameter = 8e-3, thread.pitch = 2e-3, thread.starts = starts;
    thread.leftHanded = leftHanded, thread.clearance = 0.05e-3;
    const auto fine = [=](double tolerance) {
      Thread t = thread;
      t.segments = std::clamp((circleSegments(4e-3, tolerance) + 23) / 24 * 24, 48, 384);
      return t;
    };
    LabBody a = meshBody(
        "bolt", [=](double t) { return boltMesh(fine(t), 12e-3); }, random);
    LabBody b = meshBody(
        "nut", [=](double t) { return nutMesh(fine(t), 5e-3, 13e-3); }, random);
    // A nut of two turns and a half is pressed sideways too, by the half turn and the chamfers:
    // that part is quadrature's.
    const double deep = kDepths[1] * 4e-3,
                 play = 2 * thread.clearance * std::tan(thread.flankAngle / 2);
    const double low = 2 * thread.pitch;
    const OracleForce fair =
        foundationForce(boltMesh(fine(2e-6), 12e-3), nutMesh(fine(2e-6), 5e-3, 13e-3),
                        at(0, 0, low + play + deep), 0.1e-3);
    Truth truth = towards(fair.force.normalized(), Vec3::Zero());
    truth.torquePerForce = (leftHanded ? 1 : -1) * thread.lead() / (2 * kPi);
    return Instance{a, b,
                    pressed(
                        depthsOf(4e-3), [=](double d) { return at(0, 0, low + play + d); }, truth)};
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
      {"grooves", "capsule in a V groove", false, true, kSize, true, capsuleInGroove},
      {"grooves", "spike in a crack", false, false, kSize, true, spikeInCrack},
      {"threads", "nut on its bolt", false, false, 4e-3, true, nutOnBolt(false, 1)},
      {"threads", "left-handed", false, false, 4e-3, false, nutOnBolt(true, 1)},
      {"threads", "two starts", false, false, 4e-3, false, nutOnBolt(false, 2)}};
  for (const double clearance : {1e-3, 0.5e-3, 0.2e-3, 0.1e-3, 0.05e-3}) {
    char name[64];
    std::snprintf(name, sizeof name, "peg in a hole, clearance %g mm", 1e3 * clearance);
    cases.push_back({"pegs", name, false, false, kPeg, clearance == 0.1e-3, pegInHole(clearance)});
  }
  for (const int parts : {64, 32, 16, 10}) {
    char name[64];
    std::snprintf(name, sizeof name, "plate of %.2g mm, size / %d", 1e3 * kSize / parts, parts);
    cases.push_back({"plates", name, true, true, kSize, parts == 16, sphereOnPlate(kSize / parts)});
  }
  return cases;
}

std::vector<LabCase> allCases() {
  std::vector<LabCase> cases = convexCases();
  for (LabCase& one : concaveCases()) cases.push_back(std::move(one));
  for (LabCase& one : randomCases()) cases.push_back(std::move(one));
  return cases;
}

}  // namespace cloudcontact::program::lab
