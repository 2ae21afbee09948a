// Live views without a browser: commands, the pace, pulls against mechanics, runs that nobody
// touches.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <limits>
#include <numbers>

#include "io/interrupt.h"
#include "program/program_run.h"
#include "program/scene_bodies.h"
#include "scene/simulation.h"
#include "view/live_view.h"
#include "view/pace.h"
#include "view/page_server.h"
#include "view/view_command.h"

namespace cloudcontact::program::view_run_test {
namespace {

using program_test::Workplace;
using std::chrono::milliseconds;

template <typename Command>
Command read(const std::string& text) {
  const auto command = readCommand(text);
  if (!command || !std::holds_alternative<Command>(*command)) {
    ADD_FAILURE() << text;
    return {};
  }
  return std::get<Command>(*command);
}

TEST(ViewCommandTest, ReadsWhatThePageSays) {
  read<RunOn>(R"({"do": "run"})");
  read<Pause>(R"({"do": "pause"})");
  read<StepOnce>(R"({"do": "step"})");
  read<Release>(R"({"do": "release"})");
  EXPECT_EQ(read<SetSpeed>(R"({"do": "speed", "times": 0})").times, 0);
  const auto pull =
      read<PullBody>(R"({"do": "pull", "body": 3, "at": [1, 2, 3], "to": [4.5, 5, -6]})");
  EXPECT_EQ(pull.body, 3u);
  EXPECT_EQ(pull.at, Vec3(1, 2, 3));
  EXPECT_EQ(pull.to, Vec3(4.5, 5, -6));
  const auto cut = read<CutBall>(R"({"do": "cut", "body": 0, "at": [0, 0, 1e-3], "radius": 0.01})");
  EXPECT_EQ(cut.at, Vec3(0, 0, 1e-3));
  EXPECT_EQ(cut.radius, 0.01);
}

TEST(ViewCommandTest, RefusesAllElse) {
  for (const char* text : {"",
                           "run",
                           "[]",
                           "3",
                           "null",
                           R"({"do": 3})",
                           R"({"do": "explode"})",
                           R"({"do": "run")",
                           R"({"do": "speed"})",
                           R"({"do": "speed", "times": -1})",
                           R"({"do": "speed", "times": 1e9})",
                           R"({"do": "speed", "times": 1e-20})",
                           R"({"do": "speed", "times": "1"})",
                           R"({"do": "pull", "body": 1, "at": [0, 0, 0]})",
                           R"({"do": "pull", "body": -1, "at": [0, 0, 0], "to": [0, 0, 0]})",
                           R"({"do": "pull", "body": 1.5, "at": [0, 0, 0], "to": [0, 0, 0]})",
                           R"({"do": "pull", "body": 1, "at": [0, 0], "to": [0, 0, 0]})",
                           R"({"do": "pull", "body": 1, "at": [0, 0, null], "to": [0, 0, 0]})",
                           R"({"do": "pull", "body": 1, "at": [0, 0, 1e300], "to": [0, 0, 0]})",
                           R"({"do": "pull", "body": 1, "at": [0, 0, 1e999], "to": [0, 0, 0]})",
                           R"({"do": "cut", "body": 1, "at": [0, 0, 0], "radius": 0})",
                           R"({"do": "cut", "body": 1, "at": [0, 0, 0], "radius": NaN})"})
    EXPECT_FALSE(readCommand(text)) << text;
}

TEST(ViewCommandTest, KnowsWhatOnlyTheLatestCountsOf) {
  EXPECT_TRUE(isPull(R"({"do": "pull", "body": 3, "at": [1, 2, 3], "to": [4.5, 5, -6]})"));
  for (const char* text : {"", R"({"do": "pull"})", R"({"do": "release"})", R"({"do": "step"})"})
    EXPECT_FALSE(isPull(text)) << text;
}

TEST(PaceTest, AStepThatIsDueInAgesIsNotDueNow) {
  const auto start = Pace::Clock::now();
  for (const double speed : {1e-9, 1e-20, 1e-300, std::numeric_limits<double>::denorm_min()}) {
    Pace pace;
    pace.set(speed, 1, start);
    EXPECT_EQ(pace.due(1, start), start) << speed;
    EXPECT_GT(pace.due(1.5, start), start + std::chrono::hours(24)) << speed;
  }
}

TEST(PaceTest, KeepsToAMultipleOfRealTimeAndForgetsWhatIsLost) {
  const auto start = Pace::Clock::now();
  Pace pace;
  pace.set(0.5, 10, start);
  EXPECT_EQ(pace.due(10.125, start), start + milliseconds(250));
  EXPECT_EQ(pace.due(10.125, start + milliseconds(300)), start + milliseconds(250));
  const auto late = start + milliseconds(5000);
  EXPECT_EQ(pace.due(10.125, late), late);
  EXPECT_EQ(pace.due(10.25, late), late + milliseconds(250));
  pace.set(0, 11, late);
  EXPECT_EQ(pace.due(1000, late), late);
  pace.set(1, 20, start);
  EXPECT_NEAR(pace.reached(20.3, start + milliseconds(600)), 0.5, 1e-9);
}

constexpr double kMass = 0.2;
const SceneBox kBox{Vec3(0.04, 0.03, 0.02)};

SceneDescription boxAt(const Vec3& place, const Vec3& gravity, bool withFloor = false) {
  std::vector<SceneBody> bodies = {bodyWith("box", kBox, place, kMass)};
  if (withFloor) bodies.push_back(bodyWith("floor", ScenePlane{}, Vec3::Zero(), 0));
  SceneDescription scene = sceneOf(std::move(bodies));
  scene.gravity = gravity;
  return scene;
}

void step(World& world, int steps, double length) {
  for (int i = 0; i < steps; ++i) world.step(length);
}

// Held at its center, the spring alone carries the body.
TEST(Pull, ABodyHangsByItsWeight) {
  World world(boxAt(Vec3::Zero(), Vec3(0, 0, -kGravity)), voxels(0.002));
  const BodyPull pull{0, Vec3::Zero(), Vec3(0, 0, 0.01), 1000, 20, 1};
  world.setPulls({pull});
  step(world, 2000, 0.001);
  EXPECT_NEAR(world.pose(0).position.z(), 0.01 - kMass * kGravity / 1000, 1e-5);
  EXPECT_NEAR(world.pullForces()[0].z(), kMass * kGravity, 1e-3);
}

// Without damping it swings by its own period.
TEST(Pull, SwingsLikeASpring) {
  World world(boxAt(Vec3::Zero(), Vec3::Zero()), voxels(0.002));
  const double k = 200, period = 2 * std::numbers::pi * std::sqrt(kMass / k);
  world.setPulls({{0, Vec3::Zero(), Vec3(0.01, 0, 0), k, 0, 1}});
  step(world, 10'000, period / 10'000);
  EXPECT_NEAR(world.pose(0).position.x(), 0, 1e-5);
  step(world, 5'000, period / 10'000);
  EXPECT_NEAR(world.pose(0).position.x(), 0.02, 1e-5);
}

// Far away the spring gives way: the body comes at the speed where damping bears its greatest
// force.
TEST(Pull, GivesWayBeyondItsReach) {
  World world(boxAt(Vec3::Zero(), Vec3::Zero()), voxels(0.002));
  const BodyPull pull{0, Vec3::Zero(), Vec3(100, 0, 0), 500, 20, 0.02};
  world.setPulls({pull});
  step(world, 1000, 0.001);
  EXPECT_NEAR(world.state(0).linearVelocity.x(), 500 * 0.02 / 20, 1e-3);
}

// The fastest that the box is within `seconds` [m/s].
double fastest(World& world, double seconds, double length) {
  double speed = 0;
  for (int i = 0; i < static_cast<int>(seconds / length); ++i) {
    world.step(length);
    const BodyState state = world.state(0);
    speed = std::max(speed, state.linearVelocity.norm());
  }
  return speed;
}

// By its corner, over a floor that it touches or not: a swing never grows. (Tilted on the floor,
// the box does not rest: its contact lets it creep about the vertical, at 2 mm/s in steps of 0.5 ms
// and 30 to 43 mm/s at 60 Hz, so the fastest of 4 s is chance and that of 12 s is not.)
TEST(Pull, TheFittingPullIsStableInAnyStep) {
  for (const double length : {0.0005, 0.002, 1.0 / 60, 0.05})
    for (const double height : {0.024, 0.03, 0.05, 0.1}) {
      World world(boxAt(Vec3(0, 0, 0.0101), Vec3(0, 0, -kGravity), true), voxels(0.002));
      const Vec3 corner = 0.5 * kBox.size;
      world.setPulls({world.pullOf(0, corner, Vec3(0.03, 0.01, height), length)});
      fastest(world, 2, length);
      const double early = fastest(world, 12, length), late = fastest(world, 12, length);
      EXPECT_LT(late, std::max(1.05 * early, 0.04)) << length << ' ' << height;
      EXPECT_LT(late, 0.2) << length << ' ' << height;
    }
}

TEST(Pull, FitsTheBody) {
  World world(boxAt(Vec3::Zero(), Vec3(0, 0, -kGravity)), voxels(0.002));
  const BodyPull pull = world.pullOf(0, Vec3::Zero(), Vec3::Zero(), 1e-4);
  const double radius = 0.5 * kBox.size.norm();
  EXPECT_NEAR(pull.reach, radius, 0.15 * radius);
  EXPECT_NEAR(kMass * 9.81 / pull.stiffness, 0.1 * pull.reach, 1e-6);
  EXPECT_NEAR(pull.damping, 2 * std::sqrt(pull.stiffness * kMass), 1e-6);
}

TEST(Pull, RefusesWhatCannotBePulled) {
  World world(boxAt(Vec3(0, 0, 0.05), Vec3::Zero(), true), voxels(0.002));
  EXPECT_TRUE(world.isPullable(0));
  EXPECT_FALSE(world.isPullable(1));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(world.setPulls({{1, {}, {}, 1, 1, 1}}), std::invalid_argument);
  EXPECT_THROW(world.setPulls({{2, {}, {}, 1, 1, 1}}), std::invalid_argument);
  EXPECT_THROW(world.setPulls({{0, Vec3(nan, 0, 0), Vec3::Zero(), 1, 1, 1}}),
               std::invalid_argument);
  EXPECT_THROW(world.setPulls({{0, Vec3::Zero(), Vec3::Zero(), -1, 1, 1}}), std::invalid_argument);
  EXPECT_TRUE(world.pulls().empty());
}

TEST(LiveViewTest, ARunThatNobodyTouchesIsTheSame) {
  const SceneDescription scene = boxAt(Vec3(0, 0, 0.03), Vec3(0, 0, -kGravity), true);
  SimulationSettings run;
  run.seconds = 0.3;
  run.step = 0.002;
  World plain(scene, voxels(0.002)), viewed(scene, voxels(0.002));
  const SimulationReport one = simulate(plain, run);
  LiveViewSettings page;
  page.speed = 0;
  LiveView view(viewed, 0, page, std::make_unique<PageServer>(0));
  run.goesOn = [&](double time) { return view.follow(time, [] { return true; }); };
  const SimulationReport other = simulate(viewed, run);
  EXPECT_EQ(one.hash, other.hash);
  EXPECT_EQ(one.steps, other.steps);
  EXPECT_EQ(one.maxPenetration, other.maxPenetration);
}

// A run that is ended early reports the steps that it made.
TEST(LiveViewTest, EndsWhenItIsAsked) {
  World world(boxAt(Vec3(0, 0, 1), Vec3(0, 0, -kGravity)), voxels(0.005));
  SimulationSettings run;
  run.seconds = 1000;
  run.step = 0.001;
  run.goesOn = [](double time) { return time < 0.0995; };
  const SimulationReport report = simulate(world, run);
  EXPECT_EQ(report.steps, 100);
  EXPECT_NEAR(report.bodies[0].linearVelocity.z(), -0.1 * kGravity, 1e-4);
}

TEST(InterruptTest, NotesTheFirstSignal) {
  {
    const Interrupt interrupt;
    EXPECT_FALSE(interrupt.came());
    std::raise(SIGINT);
    EXPECT_TRUE(interrupt.came());
  }
  const Interrupt again;
  EXPECT_FALSE(again.came());
  std::raise(SIGTERM);
  EXPECT_TRUE(again.came());
}

// The shell and the system both tell of a terminal that is closed, the second while files are
// written.
TEST(InterruptTest, ALostTerminalEndsInGoodOrder) {
  const auto before = std::signal(SIGHUP, SIG_DFL);
  {
    const Interrupt interrupt;
    std::raise(SIGHUP);
    EXPECT_TRUE(interrupt.came());
    std::raise(SIGHUP);
  }
  std::raise(SIGHUP);
  std::signal(SIGHUP, SIG_DFL);
  { const Interrupt interrupt; }
  EXPECT_EQ(std::signal(SIGHUP, SIG_IGN), SIG_DFL);
  {
    const Interrupt interrupt;  // under nohup
    std::raise(SIGHUP);
    EXPECT_FALSE(interrupt.came());
  }
  EXPECT_EQ(std::signal(SIGHUP, before), SIG_IGN);
}

constexpr const char* kFall = R"(<sdf version="1.9"><world name="fall"><gravity>0 0 -9.8</gravity>
<model name="ball"><pose>0 0 0.02 0 0 0</pose><link name="l"><collision name="c">
<geometry><sphere><radius>0.01</radius></sphere></geometry></collision></link></model>
<model name="floor"><static>true</static><link name="l"><collision name="c">
<geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model></world></sdf>)";

TEST(ProgramView, IsEqualToARunWithoutIt) {
  const Workplace place;
  place.write("fall.sdf", kFall);
  const std::vector<std::string> words = {"simulate",  "fall.sdf", "--voxel", "0.001",
                                          "--seconds", "0.1",      "--json"};
  std::vector<std::string> viewed = words;
  viewed.insert(viewed.end(), {"--view", "--speed", "0"});
  const auto one = place.run(words), other = place.run(viewed);
  EXPECT_EQ(other.exitCode, 0) << other.err;
  EXPECT_EQ(one.json()["hash"], other.json()["hash"]);
  EXPECT_NE(other.err.find("open http://127.0.0.1:"), std::string::npos) << other.err;
}

// A world of a large mesh takes minutes to build; this one cannot be built.
TEST(ProgramView, FindsAPortInUseBeforeItBuildsTheWorld) {
  const Workplace place;
  place.write("fall.sdf", kFall);
  const PageServer taken(0);
  const std::string port = std::to_string(taken.port());
  const auto outcome =
      place.run({"simulate", "fall.sdf", "--voxel", "1e-9", "--view", "--port", port});
  EXPECT_EQ(outcome.exitCode, 2);
  EXPECT_NE(outcome.err.find("--port: 127.0.0.1:" + port), std::string::npos) << outcome.err;
}

TEST(ProgramView, SaysWhatIsWrong) {
  const Workplace place;
  place.write("fall.sdf", kFall);
  const PageServer taken(0);
  const std::string port = std::to_string(taken.port());
  const std::vector<std::vector<std::string>> wrong = {
      {"--port", "8000"},          {"--speed", "2"},           {"--view", "--port", "70000"},
      {"--view", "--speed", "-1"}, {"--view", "--port", port},
  };
  for (const auto& words : wrong) {
    std::vector<std::string> all = {"simulate", "fall.sdf",  "--voxel",
                                    "0.002",    "--seconds", "0.01"};
    all.insert(all.end(), words.begin(), words.end());
    const auto outcome = place.run(all);
    EXPECT_EQ(outcome.exitCode, 2) << outcome.err;
    EXPECT_NE(outcome.err.find("--"), std::string::npos) << outcome.err;
  }
}

}  // namespace
}  // namespace cloudcontact::program::view_run_test
