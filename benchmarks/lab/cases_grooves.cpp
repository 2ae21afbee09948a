// Bodies in a V groove with flanks at 45 degrees: pressed equally on both flanks, unequally, or on
// one only. A hull fills the groove and by symmetry still gets the first normal right; the others,
// and the depth, expose it.
#include <cmath>
#include <numbers>

#include "lab/case_bodies.h"
#include "lab/lab_meshes.h"

namespace cloudcontact::program::lab {
namespace {

constexpr double kSize = 0.01;  // [m]
constexpr double kGroove = 1.8 * kSize;
const double kRoot2 = std::numbers::sqrt2;
// Normal of the flank at positive x.
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

// Half angle 30 degrees, edge along y at the origin.
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

// One flank is pressed by this share more than the mean, the other by as much less.
constexpr double kAside = 0.3;

// Depths at the flanks are 1 + kAside and 1 - kAside; forces are linear or quadratic in depth.
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

// The capsule pressed into both flanks by d, more or less by `aside`.
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
  const Vec3 foot(0.5 * kGroove, 0, -0.5 * kGroove);  // middle of the flank
  return {a, b,
          pressed(depthsOf(kSize),
                  [=](double d) {
                    return Pose{turnX(std::numbers::pi / 2), foot + (kSize - d) * kFlank};
                  },
                  {kFlank, 0.0, foot, {}})};
}

// The wedge's edge lies below the groove's bottom; the shortest way out is up.
Instance spikeInCrack(std::uint64_t seed) {
  Random random(seed);
  LabBody a = groovedBlock(random), b = wedgeBody(random);
  return {a, b,
          pressed(
              depthsOf(kSize), [](double d) { return at(0, 0, -kGroove - d); }, upward(1))};
}

// The wedge's edge lies in one flank: an edge on a face.
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
