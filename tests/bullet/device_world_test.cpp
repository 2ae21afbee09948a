// A world whose pairs a device searches equals one on the CPU to the bit, with pairs that have no
// kernels in the same steps, and with a device that fails.
#include "bullet/dispatch_stage.h"

#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>

#include "device/skip_without_device.h"

namespace cloudcontact::testing::device_world_test {
namespace {

constexpr double kVoxel = 1e-3;

btVector3 v(double x, double y, double z) {
  return {btScalar(x), btScalar(y), btScalar(z)};
}

std::unique_ptr<CloudShape> nut() {
  static const auto field = fieldOf(plainNut(24e-3, 12e-3, 10e-3), kVoxel);
  return std::make_unique<CloudShape>(field);
}

// Stacks of nuts, turned against each other, on a plane.
void stack(Stage& stage, int stacks, int high) {
  stage.addGround();
  for (int i = 0; i < stacks; ++i)
    for (int k = 0; k < high; ++k)
      stage.add(nut(), 0.03,
                at(v(0.03 * (i % 4) + 3e-4 * k, 0.03 * (i / 4), 0.005 + 0.00999 * k),
                   btQuaternion(v(0, 0, 1), btScalar(0.3 * i + 0.11 * k))));
}

struct Outcome {
  std::vector<std::uint64_t> hashes;
  CloudContactStatistics counted;
  CloudDispatcherStatistics dispatched;
};

using Build = std::function<void(Stage&)>;

Outcome play(const Build& build, const CloudDispatcherSettings& dispatch,
             const CloudContactSettings& settings, int steps) {
  Stage stage(dispatch, settings);
  build(stage);
  Outcome outcome;
  for (int i = 0; i < steps; ++i) {
    stage.step();
    outcome.hashes.push_back(stage.hash());
  }
  outcome.counted = stage.clouds.statistics();
  outcome.dispatched = dynamic_cast<CloudDispatcher&>(*stage.dispatcher).statistics();
  return outcome;
}

CloudDispatcherSettings onDevice(int threads) {
  return {.threads = threads, .backend = Backend::OpenCl, .leastForDevice = 1};
}

// A dispatcher with a device, for SKIP_WITHOUT.
class WithDevice {
 public:
  WithDevice() {
    btDefaultCollisionConfiguration configuration;
    try {
      CloudDispatcher(&configuration, onDevice(1));
    } catch (const std::runtime_error& why) {
      message_ = why.what();
      EXPECT_NE(message_.find("CloudDispatcherSettings::backend"), std::string::npos);
    }
  }
  const std::string& message() const { return message_; }
  Backend backend() const { return message_.empty() ? Backend::OpenCl : Backend::Cpu; }

 private:
  std::string message_;
};

// With a device the bits are the CPU's, and the counts of pairs, too.
Outcome expectSame(const Build& build, const CloudContactSettings& settings, int steps) {
  const Outcome cpu = play(build, {.threads = 1}, settings, steps);
  EXPECT_GT(cpu.counted.contacts, 0u);
  EXPECT_EQ(cpu.counted.device, 0u);
  Outcome found;
  for (const int threads : {1, 2}) {
    found = play(build, onDevice(threads), settings, steps);
    EXPECT_EQ(found.dispatched.deviceFailure, "");
    const auto first =
        std::mismatch(cpu.hashes.begin(), cpu.hashes.end(), found.hashes.begin()).first;
    EXPECT_EQ(first, cpu.hashes.end()) << "step " << first - cpu.hashes.begin();
    EXPECT_EQ(found.counted.pairs, cpu.counted.pairs);
    EXPECT_EQ(found.counted.reused, cpu.counted.reused);
    EXPECT_EQ(found.counted.samples, cpu.counted.samples);
    EXPECT_EQ(found.counted.contacts, cpu.counted.contacts);
    // Bullet may not ask again for a pair of a compound's child that met in the last step.
    EXPECT_LE(found.counted.device, found.dispatched.device.onDevice);
    EXPECT_GE(100 * found.counted.device, 98 * found.dispatched.device.onDevice);
  }
  return found;
}

TEST(DeviceWorld, StacksOfNuts) {
  const WithDevice device;
  SKIP_WITHOUT(device);
  constexpr int kSteps = 60;
  CloudContactSettings settings;
  settings.reuseMotion = 0;
  const Outcome found = expectSame([](Stage& s) { stack(s, 4, 3); }, settings, kSteps);
  // Two faces a stack and one on the plane, but for steps in which a nut lifts off.
  EXPECT_GE(found.counted.device, 4u * 3u * kSteps / 2);
  EXPECT_EQ(found.dispatched.device.shapes, 0u);
  EXPECT_EQ(found.dispatched.device.onDevice + found.dispatched.device.onCpu,
            found.dispatched.ahead);
}

TEST(DeviceWorld, PairsThatRestKeepTheirContacts) {
  const WithDevice device;
  SKIP_WITHOUT(device);
  CloudContactSettings settings;
  settings.reuseMotion = 0.02;
  const Outcome found = expectSame([](Stage& s) { stack(s, 4, 3); }, settings, 120);
  EXPECT_GT(found.counted.device, 0u);
  EXPECT_GT(found.counted.reused, 2 * found.counted.device);
}

// Nuts that fall into a heap, past each other and with Bullet's shapes and compounds among them.
TEST(DeviceWorld, AHeapOfEverything) {
  const WithDevice device;
  SKIP_WITHOUT(device);
  const Build build = [](Stage& stage) {
    stack(stage, 1, 1);
    for (int i = 0; i < 6; ++i)
      stage.add(nut(), 0.03,
                at(v(0.004 * (i % 3), 0.003 * (i % 2), 0.02 + 0.014 * i),
                   btQuaternion(v(1, 0.3 * i, 0.2).normalized(), btScalar(0.9 * i))));
    stage.add(std::make_unique<btSphereShape>(btScalar(0.008)), 0.05, at(v(0.01, 0, 0.12)));
    stage.add(std::make_unique<btBoxShape>(v(0.006, 0.009, 0.007)), 0.05, at(v(0, 0.01, 0.16)));
    auto pair = std::make_unique<btCompoundShape>();
    pair->addChildShape(at(v(0.013, 0, 0)), stage.own(nut()));
    pair->addChildShape(at(v(-0.013, 0, 0)), stage.own(nut()));
    stage.add(std::move(pair), 0.06, at(v(0, 0, 0.14)));
  };
  CloudContactSettings settings;
  settings.reuseMotion = 0;
  const Outcome found = expectSame(build, settings, 160);
  EXPECT_GT(found.dispatched.device.onDevice, 100u);
  EXPECT_GT(found.dispatched.device.nearMisses, 0u);
  EXPECT_GT(found.dispatched.device.shapes, 0u);
}

// Stated base vectors and tissues have no kernels, but the same world.
TEST(DeviceWorld, StatedBaseVectorsStayOnTheCpu) {
  const WithDevice device;
  SKIP_WITHOUT(device);
  const auto build = [](Stage& s) {
    stack(s, 1, 2);
    const btCollisionObjectArray& all = s.world.getCollisionObjectArray();
    for (int i = 0; i < all.size(); ++i) {
      if (!CloudShape::of(*all[i]->getCollisionShape())) continue;
      auto& shape = static_cast<CloudShape&>(*all[i]->getCollisionShape());
      PaperSettings paper;
      paper.window = sphereWindow(shape.cloud().voxelSize());
      shape.usePaper(paper);
    }
  };
  const Outcome found = expectSame(build, {}, 4);
  EXPECT_EQ(found.counted.device, 0u);
}

TEST(DeviceWorld, FewPairsStayOnTheCpu) {
  const WithDevice device;
  SKIP_WITHOUT(device);
  CloudDispatcherSettings few = onDevice(2);
  few.leastForDevice = 1000;
  const Outcome found = play([](Stage& s) { stack(s, 2, 2); }, few, {}, 5);
  EXPECT_EQ(found.dispatched.deviceSteps, 0u);
  EXPECT_GT(found.dispatched.ahead, 0u);
}

}  // namespace
}  // namespace cloudcontact::testing::device_world_test
