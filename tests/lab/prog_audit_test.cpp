// `cloudcontact chart --audit`: its file, its table, its error messages.
#include <gtest/gtest.h>

#include <cmath>

#include "program/program_run.h"

namespace prog_audit_test {
namespace {

using program_test::Outcome;
using program_test::Workplace;

// A brick of 2 kg that is laid on a plane.
const char* const kSlide = R"(<?xml version="1.0"?>
<sdf version="1.8"><world name="slide"><gravity>0 0 -9.8</gravity>
<physics name="p" type="bullet"><max_step_size>0.004</max_step_size></physics>
<model name="ground"><static>true</static><link name="l"><collision name="c">
<geometry><plane><normal>0 0 1</normal><size>9 9</size></plane></geometry>
<surface><friction><ode><mu>0.5</mu></ode></friction></surface></collision></link></model>
<model name="brick"><pose>0 0 0.01 0 0 0</pose><link name="l"><inertial><mass>2</mass>
<inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial>
<collision name="c"><geometry><box><size>0.2 0.2 0.02</size></box></geometry>
<surface><friction><ode><mu>0.5</mu></ode></friction></surface></collision></link></model>
</world></sdf>)";

TEST(AuditCommand, TellsWhereTheEnergyOfASceneGoes) {
  const Workplace place;
  place.write("slide.sdf", kSlide);
  const Outcome outcome = place.run(
      {"chart", "--audit", "slide.sdf", "--seconds", "0.4", "--voxel", "0.002", "--out", "out"});
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  const auto json = nlohmann::json::parse(place.read("out/audit.json"));
  EXPECT_EQ(json["steps"], 100);
  ASSERT_EQ(json["each"].size(), 100u);
  double bodies = 0;
  for (const auto& step : json["each"]) bodies += step["bodies"].get<double>();
  const auto& sum = json["sum"];
  EXPECT_NEAR(sum["bodies"], bodies, 1e-12);
  EXPECT_LT(bodies, 0);  // it sags onto its spring
  double parts = 0;
  for (const char* part : {"friction", "normals", "joints", "drivers", "solver", "turning", "rest"})
    parts += sum[part].get<double>();
  EXPECT_NEAR(sum["bodies"].get<double>() + sum["springs"].get<double>(), parts, 1e-9);
  EXPECT_NEAR(sum["rest"], 0, 1e-5);
  for (const char* kind : {"normal", "friction 1", "friction 2", "spring"})
    EXPECT_GE(json["made"][kind]["energy"].get<double>(), 0);
  EXPECT_TRUE(json.contains("worst"));
  for (const char* words : {"energy [J] of 100 steps", "bodies", "rows that made energy"})
    EXPECT_NE(outcome.out.find(words), std::string::npos) << words;
}

TEST(AuditCommand, RefusesWhatItCannotDo) {
  const Workplace place;
  place.write("slide.sdf", kSlide);
  const auto refused = [&](const std::vector<std::string>& words, const char* why) {
    const Outcome outcome = place.run(words);
    EXPECT_EQ(outcome.exitCode, 2) << outcome.err;
    EXPECT_NE(outcome.err.find(why), std::string::npos) << outcome.err;
  };
  refused({"chart", "--audit", "none.sdf"}, "none.sdf");
  refused({"chart", "--audit", "slide.sdf", "--quick"}, "--audit");
  refused({"chart", "--audit", "slide.sdf", "sphere:1"}, "--audit");
  refused({"chart", "--seconds", "1"}, "--audit");
  refused({"chart", "--audit", "slide.sdf", "--step", "1e-9"}, "--step");
}

}  // namespace

}  // namespace prog_audit_test
