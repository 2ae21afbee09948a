// A recorder's contents against mechanics: weights, friction, free fall.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "io/json.h"
#include "program/scene_bodies.h"
#include "replay/page_contacts.h"
#include "replay/page_record.h"
#include "replay/recorder.h"
#include "scene/simulation.h"

namespace cloudcontact::program::replay_recorder_test {
namespace {

// A stack of two boxes, 2 kg and 3 kg, on a floor; a ball of 1 kg falls next to it.
SceneDescription stacked(const Vec3& gravity = {0, 0, -kGravity}) {
  SceneDescription scene;
  scene.gravity = gravity;
  const SceneBox box{Vec3(0.2, 0.2, 0.2)};
  scene.bodies = {
      bodyWith("upper", box, {0, 0, 0.3}, 2), bodyWith("floor", ScenePlane{}, Vec3::Zero(), 0),
      bodyWith("lower", box, {0, 0, 0.1}, 3), bodyWith("ball", SceneSphere{0.1}, {1, 0, 50}, 1)};
  for (int i = 0; i < 4; ++i) {
    scene.bodies[std::size_t(i)].model = i;
    scene.bodies[std::size_t(i)].friction = 0.5;
    if (i != 1) scene.bodies[std::size_t(i)].stiffness = 1e5;
    if (i != 1) scene.bodies[std::size_t(i)].damping = 1e3;
  }
  return scene;
}

Replay recorded(const SceneDescription& scene, double seconds, Method method = Method::Cloud,
                std::size_t mostPoints = 3'000'000) {
  WorldSettings settings;
  settings.common.method = method;
  settings.voxel = 0.01;
  World world(scene, settings);
  Recorder recorder(mostPoints);
  recorder.begin(world, "take", seconds, kStep);
  SimulationSettings simulation;
  simulation.seconds = seconds;
  simulation.step = kStep;
  simulation.instants = 1;
  simulation.observe = [&](double time, const World& now) { recorder.record(time, now); };
  simulate(world, simulation);
  return recorder.finish();
}

std::vector<ReplayPatch> lastPatches(const ReplayTake& take) {
  std::vector<ReplayPatch> patches;
  for (const std::uint32_t i : take.contacts.shownAt(take.frames.size() - 1))
    patches.push_back(take.contacts.patches()[i]);
  return patches;
}

// The sum of the forces on `body` in the last frame, and the deepest point.
struct Pushed {
  Vec3 force = Vec3::Zero();
  double depth = 0;
};
Pushed pushedAtEnd(const ReplayTake& take, int body, int by) {
  Pushed sum;
  for (const ReplayPatch& patch : lastPatches(take))
    for (const ReplayPoint& p : take.contacts.of(patch)) {
      if (patch.b == body && patch.a == by) sum.force += p.force.cast<double>();
      if (patch.a == body && patch.b == by) sum.force -= p.force.cast<double>();
      if (patch.a + patch.b == body + by) sum.depth = std::max(sum.depth, double(p.depth));
    }
  return sum;
}

TEST(Recorder, ForcesCarryTheWeight) {
  for (const Method method : {Method::Cloud, Method::Primitive}) {
    const Replay replay = recorded(stacked(), 2, method);
    ASSERT_EQ(replay.takes.size(), 1u);
    const ReplayTake& take = replay.takes[0];
    const Vec3 onUpper = pushedAtEnd(take, 0, 2).force, onLower = pushedAtEnd(take, 2, 1).force;
    EXPECT_NEAR(onUpper.z(), 2 * kGravity, 0.02 * 2 * kGravity);
    EXPECT_NEAR(onLower.z(), 5 * kGravity, 0.02 * 5 * kGravity);
    EXPECT_LT(onUpper.head<2>().norm(), 0.1);
    // A fixed body is the first of a patch: arrows show the forces on the moving one.
    for (const ReplayPatch& patch : lastPatches(take)) {
      EXPECT_NE(patch.b, 1);
      if (patch.a == 1) {
        EXPECT_GT(patch.normal.z(), 0.999);
      }
    }
  }
}

// On a slope the force is vertical: its component along the slope is friction.
TEST(Recorder, ForcesHoldTheirFriction) {
  const double slope = 0.3;
  const Vec3 gravity = kGravity * Vec3(std::sin(slope), 0, -std::cos(slope));
  const Replay replay = recorded(stacked(gravity), 3);
  const Vec3 onLower = pushedAtEnd(replay.takes[0], 2, 1).force;
  EXPECT_LT((onLower + 5 * gravity).norm(), 0.03 * 5 * kGravity)
      << onLower.transpose() << " for " << 5 * gravity.transpose();
}

// A disc has the second moment of a uniform patch of the box's face: (a^2 + b^2) / 12 = R^2 / 2.
TEST(Recorder, DiscsAreAsLargeAsTheirPatches) {
  const Replay replay = recorded(stacked(), 1);
  for (const ReplayPatch& patch : lastPatches(replay.takes[0])) {
    EXPECT_NEAR(patch.radius, 0.2 / std::sqrt(3.0), 0.1 * 0.2);
    EXPECT_NEAR(patch.position.x(), 0, 2e-3);
  }
}

TEST(Recorder, FiguresAreThoseOfTheRun) {
  const Replay replay = recorded(stacked(), 2);
  const ReplayTake& take = replay.takes[0];
  EXPECT_NEAR(replay.seconds, 2, 1e-9);
  ASSERT_GE(take.frames.size(), 240u);
  for (std::size_t i = 1; i < take.frames.size(); ++i) {
    const ReplayFrame& frame = take.frames[i];
    EXPECT_GT(frame.time, take.frames[i - 1].time);
    EXPECT_GT(frame.narrowPhase, 0);
    // The ball falls freely and the boxes rest: kinetic energy replaces potential energy, but for
    // the integrator's error, m g h v / 2.
    const double before = frame.time - kStep;
    const double fallen = 0.5 * kGravity * before * before;
    EXPECT_NEAR(frame.kinetic, kGravity * fallen, 0.01 * kGravity * fallen + 0.1);
    EXPECT_NEAR(frame.potential, kGravity * (50 - fallen + 2 * 0.3 + 3 * 0.1),
                0.01 * kGravity * fallen + 0.1);
  }
  // Two springs in series between the boxes; the floor, without stiffness, is rigid.
  const double sag = 5 * kGravity / 1e5;
  EXPECT_NEAR(take.frames.back().deepest, sag, 0.05 * sag);
}

// With too many contacts every other frame is dropped, but its deepest contact is kept.
TEST(Recorder, KeepsTheDeepestWhereFramesAreLeftOut) {
  const ReplayTake all = recorded(stacked(), 1).takes[0];
  const ReplayTake some = recorded(stacked(), 1, Method::Cloud, 60).takes[0];
  EXPECT_LE(2 * some.frames.size(), all.frames.size() + 1);
  EXPECT_EQ(some.frames.size(), some.contacts.frames());
  const double end = some.frames.back().time;
  const auto deepest = [end](const ReplayTake& take) {
    double most = 0;
    for (const ReplayFrame& frame : take.frames)
      if (frame.time <= end) most = std::max(most, frame.deepest);
    return most;
  };
  EXPECT_DOUBLE_EQ(deepest(some), deepest(all));
  EXPECT_GT(end, 0.8);
}

TEST(Recorder, TakesStandBesideEachOther) {
  WorldSettings settings;
  settings.common.method = Method::Primitive;
  settings.voxel = 0.01;
  const SceneDescription scene = stacked();
  Recorder recorder;
  for (const char* label : {"one", "two", "three"}) {
    World world(scene, settings);
    recorder.begin(world, label, 0.1, kStep);
    recorder.record(0, world);
  }
  const Replay replay = recorder.finish();
  ASSERT_EQ(replay.takes.size(), 3u);
  for (std::size_t i = 1; i < 3; ++i) {
    const ReplayTake &before = replay.takes[i - 1], &here = replay.takes[i];
    EXPECT_GT(here.offset.x() + here.extent.min().x(), before.offset.x() + before.extent.max().x());
  }
  EXPECT_EQ(replay.takes[2].label, "three");
}

// The page's record holds the same contacts, rounded. Reads it as page/record.js does.
TEST(PageRecord, HoldsTheContactsThatWereSeen) {
  const Replay replay = recorded(stacked(), 1);
  const std::string bytes = pageRecord(replay);
  ASSERT_EQ(bytes.substr(0, 4), "RPLY");
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 4, 4);
  ASSERT_EQ((8 + length) % 8, 0u);
  const Json json = Json::parse(bytes.substr(8, length));
  const auto number = [&](const Json& array, std::size_t i, auto kind) {
    EXPECT_LT(i, array["length"].get<std::size_t>());
    std::memcpy(&kind, bytes.data() + 8 + length + array["at"].get<std::size_t>() + i * sizeof kind,
                sizeof kind);
    return double(kind);
  };
  const Json& contacts = json["takes"][0]["contacts"];
  const std::size_t frame = replay.takes[0].frames.size() - 1;
  const auto shown = std::size_t(number(contacts["firstShown"], frame, std::uint32_t()));
  ASSERT_EQ(number(contacts["firstShown"], frame + 1, std::uint32_t()) - double(shown), 2);
  const auto patch = std::size_t(number(contacts["shown"], shown + 1, std::uint32_t()));
  const auto first = std::size_t(number(contacts["patchPoint"], patch, std::uint32_t()));
  const ReplayPatch seen = lastPatches(replay.takes[0])[1];
  ASSERT_EQ(number(contacts["patchCount"], patch, std::uint16_t()), double(seen.points));
  const double grid = contacts["grid"];
  const std::span<const ReplayPoint> points = replay.takes[0].contacts.of(seen);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const ReplayPoint& p = points[i];
    const double share = number(contacts["pointForce"], first + i, std::uint16_t()) / 1023;
    const double most = contacts["mostForce"], force = most * share * share;
    EXPECT_NEAR(force, p.force.norm(), 0.002 * most);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double place =
          grid * number(contacts["pointPlace"], 3 * (first + i) + axis, std::int32_t());
      EXPECT_NEAR(place, p.position[Eigen::Index(axis)], grid);
      EXPECT_NEAR(number(contacts["pointDirection"], 3 * (first + i) + axis, std::int8_t()) / 127,
                  p.force.normalized()[Eigen::Index(axis)], 0.005);
    }
    EXPECT_NEAR(contacts["mostDepth"].get<double>() / 1023 *
                    number(contacts["pointDepth"], first + i, std::int16_t()),
                p.depth, contacts["mostDepth"].get<double>() / 1023);
  }
  EXPECT_EQ(json["shells"].size(), 2u);  // the boxes are one cloud, the ball another
}

// A ball that flies off takes no digits from the contact of a box at rest.
TEST(PageRecord, ABodyThatFliesOffSpoilsNoOthersContacts) {
  SceneDescription scene = stacked();
  scene.bodies.back().linearVelocity = {1e4, 0, 0};
  scene.bodies.back().pose.position.z() = 0.11;
  scene.bodies.back().friction = 0;
  const Replay replay = recorded(scene, 1);
  const ReplayTake& take = replay.takes[0];
  PackedArrays arrays;
  const double size = take.start.diagonal().norm();
  const Json contacts = contactsJson(take.contacts, arrays);
  EXPECT_LT(contacts["grid"].get<double>(), 2e-4 * size);
  EXPECT_LT(contacts["mostDepth"].get<double>(), 0.01);
}

}  // namespace
}  // namespace cloudcontact::program::replay_recorder_test
