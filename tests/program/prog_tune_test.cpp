// `cloudcontact tune`: the names in its JSON, and that its choice holds the tolerance where the
// contact is known in closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "program/program_run.h"

namespace prog_tune_test {
namespace {

using nlohmann::json;
using program_test::Outcome;
using program_test::Workplace;

using Words = std::vector<std::string>;

json tuned(const Workplace& place, Words words) {
  words.insert(words.begin(), "tune");
  words.push_back("--json");
  const Outcome outcome = place.run(words);
  EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
  return outcome.exitCode == 0 ? outcome.json() : json();
}

// A ball of 10 mm, 0.2 mm deep in a slab.
constexpr double kDepth = 2e-4;
const Words kBall = {"box:0.03,0.028,0.008", "sphere:0.01", "--pose", "0.001 -0.002 0.0138"};

Words with(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

// k d at the settings chosen.
double depthAt(const Workplace& place, const json& chosen) {
  const Outcome outcome = place.run(
      with({"contact"}, with(kBall, {"--json", "--repeat", "1", "--stiffness", "1", "--voxel",
                                     std::to_string(chosen["voxel"].get<double>()), "--samples",
                                     std::to_string(chosen["samples"].get<int>())})));
  EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
  const json force = outcome.json()["force"];
  return std::hypot(force[0].get<double>(), force[1].get<double>(), force[2].get<double>());
}

TEST(Tune, HasTheDocumentedNames) {
  const Workplace place;
  const json result = tuned(place, with(kBall, {"--tolerance", "3e-4"}));
  EXPECT_EQ(result.at("tolerance"), 3e-4);
  for (const char* name : {"voxel", "samples", "level", "reuse"})
    EXPECT_TRUE(result.at("chosen").at(name).is_number()) << name;
  for (const char* name : {"predictedError", "measuredError", "microseconds", "bytes"})
    EXPECT_TRUE(result.at(name).is_number()) << name;
  for (const char* step : {"finer", "coarser"})
    for (const char* name :
         {"error", "microseconds", "voxel", "samples", "predictedError", "bytes"})
      EXPECT_TRUE(result.at(step).at(name).is_number()) << step << ' ' << name;
  EXPECT_TRUE(place.files().empty());
}

TEST(Tune, ItsChoiceHoldsTheTolerance) {
  const Workplace place;
  double voxel = 1;
  for (const double tolerance : {3e-4, 1e-4}) {
    SCOPED_TRACE(tolerance);
    const json result = tuned(place, with(kBall, {"--tolerance", std::to_string(tolerance)}));
    EXPECT_LE(result["predictedError"], tolerance);
    EXPECT_LE(result["measuredError"], tolerance);
    EXPECT_NEAR(depthAt(place, result["chosen"]), kDepth, tolerance);
    EXPECT_LT(result["chosen"]["voxel"], voxel);
    voxel = result["chosen"]["voxel"];
    const double step = result["coarser"]["voxel"].get<double>() / voxel;
    EXPECT_NEAR(step, std::sqrt(2), 1e-6);
    EXPECT_NEAR(voxel / result["finer"]["voxel"].get<double>(), std::sqrt(2), 1e-6);
    EXPECT_GT(result["finer"]["bytes"], result["bytes"]);
    EXPECT_LT(result["coarser"]["bytes"], result["bytes"]);
  }
}

// The choice counts lookups and reads no clock.
TEST(Tune, ChoosesTheSameAgain) {
  const Workplace place;
  const Words words = with(kBall, {"--tolerance", "2e-4"});
  json first = tuned(place, words), second = tuned(place, with(words, {"--threads", "1"}));
  for (const char* name : {"chosen", "predictedError", "measuredError", "bytes"})
    EXPECT_EQ(first[name], second[name]) << name;
}

TEST(Tune, TakesAHalfSpaceAndPrintsATable) {
  const Workplace place;
  const Outcome outcome = place.run(
      {"tune", "halfspace", "sphere:0.01", "--pose", "0 0 0.0098", "--tolerance", "2e-4"});
  EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
  for (const char* word : {"coarser", "chosen", "finer", "--voxel", "--samples"})
    EXPECT_NE(outcome.out.find(word), std::string::npos) << word;
}

TEST(Tune, ASavedCloudKeepsItsVoxels) {
  const Workplace place;
  ASSERT_EQ(
      place.run({"digitize", "sphere:0.01", "--voxel", "0.0005", "-o", "ball.cloud"}).exitCode, 0);
  const Words words = {"tune", "halfspace", "ball.cloud", "--pose", "0 0 0.0098", "--json"};
  const Outcome kept = place.run(with(words, {"--tolerance", "1e-4"}));
  ASSERT_EQ(kept.exitCode, 0) << kept.err;
  EXPECT_EQ(kept.json()["chosen"]["voxel"], 0.0005);
  EXPECT_TRUE(kept.json()["measuredError"].is_null());
  EXPECT_TRUE(kept.json()["finer"].is_null());
  const Outcome refused = place.run(with(words, {"--tolerance", "1e-7"}));
  EXPECT_EQ(refused.exitCode, 2);
  EXPECT_NE(refused.err.find("saved cloud"), std::string::npos) << refused.err;
}

const char* const kScene = R"(<sdf version="1.9"><world name="w">
<physics name="p" type="x"><max_step_size>0.001</max_step_size></physics>
<model name="slab"><static>true</static><pose>0 0 -0.004 0 0 0</pose><link name="l">
<collision name="c"><geometry><box><size>0.03 0.028 0.008</size></box></geometry>
<surface><friction><ode><mu>0.5</mu></ode></friction></surface></collision></link></model>
<model name="ball"><pose>0 0 0.00999 0 0 0</pose><link name="l"><inertial><mass>0.03</mass></inertial>
<collision name="c"><geometry><sphere><radius>0.01</radius></sphere></geometry>
</collision></link></model></world></sdf>)";

TEST(Tune, TakesAScene) {
  const Workplace place;
  place.write("ball.sdf", kScene);
  const json result = tuned(place, {"ball.sdf", "--tolerance", "2e-4", "--seconds", "0.05"});
  EXPECT_LE(result["predictedError"], 2e-4);
  EXPECT_LE(result["measuredError"], 2e-4);
  EXPECT_EQ(result["places"], 4) << "one pair at four instants";
}

TEST(Tune, TakesTissues) {
  const Workplace place;
  const Words words = with(kBall, {"--tolerance", "2e-4", "--tissues", "dental"});
  const json result = tuned(place, with(words, {"--tissue", "all=enamel"}));
  EXPECT_LE(result["measuredError"], 2e-4);
  const Words unknown = with(words, {"--tissue", "all=iron"});
  EXPECT_NE(place.run(with({"tune"}, unknown)).err.find("iron"), std::string::npos);
}

TEST(Tune, RefusesWhatItCannotDo) {
  const Workplace place;
  place.write("ball.sdf", kScene);
  const Words apart = {"box:0.03,0.028,0.008", "sphere:0.01", "--pose", "0 0 0.1"};
  const struct {
    Words words;
    const char* names;
  } cases[] = {
      {kBall, "--tolerance"},
      {with(kBall, {"--tolerance", "0"}), "greater than 0"},
      {with(kBall, {"--tolerance", "1e-9"}), "of memory"},
      {with(kBall, {"--tolerance", "1e-9"}), "give --tolerance"},
      {with(kBall, {"--tolerance", "1e-4", "--voxel", "0.001"}), "--voxel"},
      {with(apart, {"--tolerance", "1e-4"}), "do not touch"},
      {with(kBall, {"--tolerance", "1e-4", "--seconds", "1"}), "--seconds"},
      {with(kBall, {"--tolerance", "1e-4", "--law", "rigid"}), "--law"},
      {{"sphere:0.01", "sphere:0.01", "--tolerance", "1e-4"}, "--pose"},
      {{"sphere:0.01", "--tolerance", "1e-4"}, "A and B"},
      {{"ball.sdf", "sphere:0.01", "--tolerance", "1e-4"}, "sphere:0.01"},
      {{"halfspace", "halfspace", "--pose", "0 0 0", "--tolerance", "1e-4"}, "halfspace"},
      {{"none.sdf", "--tolerance", "1e-4"}, "none.sdf"},
  };
  for (const auto& one : cases) {
    const Outcome outcome = place.run(with({"tune"}, one.words));
    EXPECT_EQ(outcome.exitCode, 2) << one.names;
    EXPECT_NE(outcome.err.find(one.names), std::string::npos) << outcome.err;
    EXPECT_TRUE(outcome.out.empty());
  }
}

}  // namespace

}  // namespace prog_tune_test
