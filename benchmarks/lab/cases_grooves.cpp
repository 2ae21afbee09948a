// What lies in a V groove with flanks at 45 degrees: on both alike, on one more than on the other,
// on one alone. A hull fills the groove, and by symmetry has the normal of the first right; only
// the others, and the depth, show it.
#include <cmath>
#include <numbers>

#include "lab/case_parts.h"
#include "lab/solids.h"

namespace cloudcontact::program::lab {
namespace {

constexpr double kSize = 0.01;  // [m]
constexpr double kGroove = 1.8 * kSize;
const double kRoot2 = std::numbers::sqrt2;
// The flank at positive x pushes this way.
const Vec3 kFlank = Vec3(-1, 0, 1).normalized();

// The block's top at z = 0, the groove along y, its bottom at -kGroove.
LabBody groovedBlock(Random& random) {
  const double half = 2.5 * kSize;
  const Outline section = {{-half, -half}, {half, -half}, {half, 0}, {kGroove, 0},
                           {0, -kGroove},  {-kGroove, 0}, {-half, 0}};
  return meshBody(
      "block with a V groove",
      [=](double) {
        return moved(prism(section, -2 * kSize, 2 * kSize),
                     {turnX(std::numbers::pi / 2), Vec3::Zero()});
      },
      random);
}

LabBody capsuleBody(Random& random) {
  return primitiveBody("capsule", Capsule{kSize, 0.8 * kSize}, random);
}

// Of half angle 30 degrees, its edge along y at the origin.
LabBody wedgeBody(Random& random) {
  const Outline section = {
      {0, 0}, {kSize, std::sqrt(3.0) * kSize}, {-kSize, std::sqrt(3.0) * kSize}};
  return meshBody(
      "wedge",
      [=](double) {
        return moved(prism(section, -kSize, kSize), {turnX(std::numbers::pi / 2), Vec3::Zero()});
      },
      random, true);
}

// How much more than the mean the one flank is pressed, and the other less.
constexpr double kAside = 0.3;

// Flanks pressed by 1 + kAside and 1 - kAside: as their depths say, or as the depths' squares.
Truth leaning(double deepest) {
  const auto towards = [](double more, double less) {
    return (more * kFlank + less * Vec3(-kFlank.x(), 0, kFlank.z())).normalized();
  };
  Truth truth{towards(1 + kAside, 1 - kAside), {}, {}, {}};
  truth.squareLaw = towards(std::pow(1 + kAside, 2), std::pow(1 - kAside, 2));
  truth.deepest = deepest;
  return truth;
}

Truth upward(double deepest) {
  Truth truth{Vec3::UnitZ(), {}, Vec3::Zero(), {}};
  truth.deepest = deepest;
  return truth;
}

// The axis where the capsule touches both flanks, pressed into each by d.
Pose capsuleAt(double d, double aside) {
  return at(kRoot2 * aside * d, 0, -kGroove + kRoot2 * (kSize - d), turnX(std::numbers::pi / 2));
}

Instance capsuleInGroove(std::uint64_t seed) {
  Random random(seed);
  LabBody a = groovedBlock(random), b = capsuleBody(random);
  return {a, b,
          pressed(
              depthsOf(kSize), [](double d) { return capsuleAt(d, 0); }, upward(1))};
}

Instance capsuleAside(std::uint64_t seed) {
  Random random(seed);
  LabBody a = groovedBlock(random), b = capsuleBody(random);
  return {a, b,
          pressed(
              depthsOf(kSize), [](double d) { return capsuleAt(d, kAside); }, leaning(1 + kAside))};
}

Instance capsuleOnFlank(std::uint64_t seed) {
  Random random(seed);
  LabBody a = groovedBlock(random), b = capsuleBody(random);
  const Vec3 foot(0.5 * kGroove, 0, -0.5 * kGroove);  // the flank's middle
  return {a, b,
          pressed(depthsOf(kSize),
                  [=](double d) {
                    return Pose{turnX(std::numbers::pi / 2), foot + (kSize - d) * kFlank};
                  },
                  {kFlank, 0.0, foot, {}})};
}

// The edge below the groove's bottom, which is the nearest that it has to part from.
Instance spikeInCrack(std::uint64_t seed) {
  Random random(seed);
  LabBody a = groovedBlock(random), b = wedgeBody(random);
  return {a, b,
          pressed(
              depthsOf(kSize), [](double d) { return at(0, 0, -kGroove - d); }, upward(1))};
}

// The edge in one flank: an edge on a face, whichever way the spike leans.
Instance spikeOnFlank(std::uint64_t seed) {
  Random random(seed);
  LabBody a = groovedBlock(random), b = wedgeBody(random);
  const Vec3 foot(0.5 * kGroove, 0, -0.5 * kGroove);
  return {a, b,
          pressed(depthsOf(kSize),
                  [=](double d) {
                    return Pose{Eigen::Quaterniond::Identity(), foot - d * kFlank};
                  },
                  {kFlank, 0.0, {}, {}})};
}

}  // namespace

std::vector<LabCase> grooveCases() {
  return {{"grooves", "capsule in a V groove", false, true, kSize, true, capsuleInGroove},
          {"grooves", "capsule aside in a V groove", false, true, kSize, true, capsuleAside},
          {"grooves", "capsule on a V groove's flank", false, true, kSize, true, capsuleOnFlank},
          {"grooves", "spike in a crack", false, false, kSize, true, spikeInCrack},
          {"grooves", "spike on a crack's flank", false, false, kSize, false, spikeOnFlank}};
}

}  // namespace cloudcontact::program::lab
