// The command `chart`: a user's pair, its output files, its error messages.
#include <gtest/gtest.h>

#include <filesystem>

#include "program/program_run.h"

namespace prog_chart_test {
namespace {

using program_test::Outcome;
using program_test::Workplace;

TEST(Chart, OfAUsersPair) {
  const Workplace place;
  const Outcome outcome = place.run({"chart", "sphere:0.01", "box:0.03,0.03,0.01", "--pose",
                                     "0 0 0.0147", "--voxel", "0.001", "--out", "out"});
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  for (const char* file : {"chart.json", "chart.svg", "chart.png", "failures.json", "report.html"})
    EXPECT_GT(std::filesystem::file_size(place / "out" / file), 10u) << file;
  const auto json = nlohmann::json::parse(place.read("out/chart.json"));
  ASSERT_GT(json["rows"].size(), 5u);
  int answered = 0;
  for (const auto& row : json["rows"]) {
    for (const char* field : {"family", "case", "convex", "method", "setting", "microseconds",
                              "normalDeg", "depth", "centre", "force", "torque", "frontier",
                              "triangles", "wrongDepth", "swappedNormalDeg", "loopWork", "volume"})
      EXPECT_TRUE(row.contains(field)) << field;
    if (!row["why"].get<std::string>().empty()) continue;
    ++answered;
    EXPECT_GT(row["microseconds"].get<double>(), 0);
    EXPECT_LT(row["normalDeg"]["mean"].get<double>(), 10)
        << row;  // sphere on face: all methods agree
  }
  EXPECT_GT(answered, 4);
  for (const auto& method : json["methods"])
    EXPECT_GT(method["told"].get<std::string>().size(), 20u) << method;
  EXPECT_GT(json["ratios"].size(), 3u);
  EXPECT_TRUE(json["versions"].contains("bullet") && json["versions"].contains("HACD"));
  const std::string report = place.read("out/report.html");
  EXPECT_NE(report.find("<svg"), std::string::npos);
  EXPECT_EQ(report.find(">nan"), std::string::npos);  // unknown values are dashes
  for (const char* outside : {"src=\"", "href=\"http"})
    EXPECT_EQ(report.find(outside), std::string::npos) << outside;
}

TEST(Chart, RefusesUnusablePairs) {
  const Workplace place;
  const auto refused = [&](const std::vector<std::string>& words, const char* why) {
    const Outcome outcome = place.run(words);
    EXPECT_EQ(outcome.exitCode, 2) << outcome.err;
    EXPECT_NE(outcome.err.find(why), std::string::npos) << outcome.err;
  };
  refused({"chart", "sphere:1"}, "give A, B and --pose");
  refused({"chart", "sphere:1", "no_such.stl", "--pose", "0 0 1"}, "no_such.stl");
  EXPECT_TRUE(place.files().empty()) << "no folder is left";
  refused({"chart", "--quick", "--no-stability", "--only", "nosuchcase"}, "nosuchcase");
  EXPECT_TRUE(place.files().empty()) << "no folder is left";
  refused({"chart", "--voxel", "0.001"}, "--voxel");
  refused({"chart", "--method", "magic"}, "cloud, paper");
  refused({"chart", "--law", "paper"}, "--law");
  refused({"chart", "--no-accuracy", "--no-stability"}, "--no-accuracy");
  refused({"chart", "--stiffness", "3"}, "--stiffness");
  place.write("file", "x");
  refused({"chart", "sphere:1", "sphere:1", "--pose", "0 0 1.9", "--out", "file"}, "--out");
}

TEST(Chart, OfOneMethod) {
  const Workplace place;
  const Outcome outcome =
      place.run({"chart", "sphere:0.01", "box:0.03,0.03,0.01", "--pose", "0 0 0.0147", "--voxel",
                 "0.001", "--method", "paper", "--out", "out"});
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  const auto json = nlohmann::json::parse(place.read("out/chart.json"));
  ASSERT_EQ(json["rows"].size(), 3u);
  for (const auto& row : json["rows"]) EXPECT_EQ(row["method"], "paper");
}

TEST(Chart, SaysWhereTheBodiesDoNotTouch) {
  const Workplace place;
  const Outcome outcome = place.run({"chart", "sphere:0.01", "sphere:0.01", "--pose", "0 0 0.03",
                                     "--voxel", "0.002", "--out", "out"});
  EXPECT_EQ(outcome.exitCode, 1);
  EXPECT_NE(outcome.err.find("do not touch"), std::string::npos) << outcome.err;
}

}  // namespace

}  // namespace prog_chart_test
