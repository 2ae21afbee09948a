// `cloudcontact drill` from the command line: a body of two materials, output files, and bad input.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "program/obj_file.h"
#include "program/program_run.h"
#include "scene/tooth.h"

namespace prog_drill_test {
namespace {

using nlohmann::json;
using program_test::Outcome;
using program_test::Workplace;
using Arguments = std::vector<std::string>;

// A block of two layers, 6 by 6 by 4 mm, as an OBJ file in mm: "crust" is the whole block, "core"
// its lower 3 mm.
void writeBlock(const Workplace& place) {
  std::string text;
  int base = 1;
  for (const auto& [name, top] : {std::pair("crust", 4.0), {"core", 3.0}}) {
    text += std::string("o ") + name + "\n";
    for (int k = 0; k < 8; ++k)
      text += "v " + std::to_string(k & 4 ? 3 : -3) + " " + std::to_string(k & 2 ? 3 : -3) + " " +
              std::to_string(k & 1 ? top : 0.0) + "\n";
    for (const char* face :
         {"013", "032", "467", "475", "045", "051", "237", "276", "026", "064", "157", "173"}) {
      text += "f";
      for (int k = 0; k < 3; ++k) text.append(" ").append(std::to_string(base + face[k] - '0'));
      text += "\n";
    }
    base += 8;
  }
  place.write("block.obj", text);
}

const Arguments kDrill = {"drill",    "block.obj",   "--unit",       "mm",       "--voxel",
                          "0.0002",   "--bur",       "sphere:0.001", "--tissue", "crust=enamel",
                          "--tissue", "core=dentin", "--seconds",    "8"};

Arguments with(Arguments arguments, const Arguments& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

json drilled(const Workplace& place, const Arguments& more = {}) {
  const Outcome outcome = place.run(with(kDrill, with({"--json"}, more)));
  EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  return outcome.json();
}

TEST(Drill, ReportsTouchedTissuesAndRemovedVolume) {
  const Workplace place;
  writeBlock(place);
  const json result = drilled(place, {"--force", "force.csv", "--chart", "chart.svg", "--picture",
                                      "left.png", "-o", "left.cloud"});
  EXPECT_EQ(place.files(), (std::set<std::string>{"block.obj", "force.csv", "chart.svg", "left.png",
                                                  "left.cloud"}));
  for (const char* name : {"voxelSize", "step", "ticks", "mostForce", "cutVolume", "workVolume",
                           "cutMass", "energy", "leastEnergy", "hash"})
    EXPECT_TRUE(result.at(name).is_number()) << name;
  const double cut = result["cutVolume"], work = result["workVolume"];
  EXPECT_GT(cut, 1e-9);
  EXPECT_NEAR(cut, work, 0.03 * work);
  EXPECT_GE(result["leastEnergy"].get<double>(), -1e-6);
  ASSERT_EQ(result["tissues"].size(), 2u);
  EXPECT_EQ(result["tissues"][0]["name"], "enamel (crust)");
  const double crust = result["tissues"][0]["firstTouch"],
               core = result["tissues"][1]["firstTouch"];
  EXPECT_LT(crust, core);
  EXPECT_GT(result["tissues"][0]["meanForce"].get<double>(),
            1.5 * result["tissues"][1]["meanForce"].get<double>())
      << "enamel is harder";
  // The saved cloud lacks the removed volume; masses follow from the densities of the tissues.
  const json left = place.run({"digitize", "left.cloud", "--json"}).json();
  EXPECT_NEAR(144e-9 - left["volume"].get<double>(), cut, 1e-3 * cut + 1e-12);
  const double mass = 2970 * result["tissues"][0]["cutVolume"].get<double>() +
                      2140 * result["tissues"][1]["cutVolume"].get<double>();
  EXPECT_NEAR(result["cutMass"].get<double>(), mass, 1e-6 * mass);
  // One line per tick; the last one holds the reported sums.
  std::istringstream csv(place.read("force.csv"));
  std::string line, last;
  std::getline(csv, line);
  EXPECT_EQ(line.find("time,x,y,z,toolX"), 0u);
  int lines = 0;
  for (; std::getline(csv, line); ++lines) last = line;
  EXPECT_EQ(lines, result["ticks"].get<int>());
  EXPECT_EQ(std::count(last.begin(), last.end(), ','), 15);
  const std::string chart = place.read("chart.svg");
  for (const char* word : {"enamel (crust)", "dentin (core)", "time [s]", "Force on the hand [N]"})
    EXPECT_NE(chart.find(word), std::string::npos) << word;
  EXPECT_EQ(place.read("left.png").substr(1, 3), "PNG");
}

TEST(Drill, SameCommandSameHash) {
  const Workplace place;
  writeBlock(place);
  const json one = drilled(place, {"--threads", "1"}), two = drilled(place, {"--threads", "2"});
  for (const char* name : {"hash", "mostForce", "cutVolume", "energy", "ticks"})
    EXPECT_EQ(one[name], two[name]) << name;
}

// A body and tool ten times as large: the removed volume must still follow the law.
TEST(Drill, WorksAtAnySize) {
  const Workplace place;
  const Outcome outcome = place.run({"drill", "box:0.06,0.06,0.04", "--voxel", "0.002", "--bur",
                                     "sphere:0.01", "--seconds", "1", "--json"});
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  const json result = outcome.json();
  EXPECT_GT(result["mostForce"].get<double>(), 1);
  EXPECT_NEAR(result["cutVolume"].get<double>(), result["workVolume"].get<double>(),
              0.03 * result["workVolume"].get<double>());
}

TEST(Drill, RefusesByName) {
  const Workplace place;
  writeBlock(place);
  place.write("table.json", "[{\"name\": \"wood\", \"stiffness\": 1000}]");
  place.write("words.json", "these are words");
  place.write("negative.json",
              "[{\"name\": \"wood\", \"stiffness\": -1, \"damping\": 0, \"hardness\": 1e7, "
              "\"density\": 500}]");
  const std::set<std::string> before = place.files();
  const Arguments block = {"drill", "block.obj", "--unit", "mm", "--voxel", "0.0002"};
  const Arguments known = with(block, {"--tissue", "crust=enamel", "--tissue", "core=dentin"});
  const std::pair<Arguments, const char*> table[] = {
      {{"drill"}, "WORKPIECE"},
      {{"drill", "gone.obj"}, "gone.obj"},
      {block, "its part crust is no tissue"},
      {with(block, {"--tissue", "crust"}), "PART=TISSUE"},
      {with(block, {"--tissue", "crust=iron"}), "enamel, dentin, pulp, caries"},
      {with(block, {"--tissue", "lid=enamel"}), "has no part lid"},
      {with(known, {"--bur", "sphere:0.0001"}), "sphere:0.0001 is thinner"},
      {with(known, {"--bur", "halfspace"}), "halfspace"},
      {with(known, {"--bur", "gone.stl"}), "gone.stl"},
      {with(kDrill, {"--from", "0 0 0.002"}), "--from"},
      {with(kDrill, {"--from", "0 0 nan"}), "--from"},
      {with(kDrill, {"--from", "0 0 0.01", "--to", "0 0 0.01"}), "--to"},
      {with(kDrill, {"--step", "1e-9"}), "--step"},
      {with(kDrill, {"--efficiency", "2"}), "--efficiency"},
      {with(kDrill, {"--force", "a.txt"}), "--force"},
      {with(kDrill, {"--chart", "a.pdf"}), "--chart"},
      {with(kDrill, {"--picture", "no/such/a.png"}), "--picture"},
      {with(kDrill, {"-o", "a.stl"}), "-o"},
      {with(block, {"--tissues", "soup"}), "--tissues"},
      {with(block, {"--tissues", "words.json"}), "words.json"},
      {with(block, {"--tissues", "table.json"}), "damping"},
      {with(block, {"--tissues", "negative.json"}), "stiffness"}};
  for (const auto& [arguments, says] : table) {
    const Outcome outcome = place.run(arguments);
    EXPECT_EQ(outcome.exitCode, 2) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_NE(outcome.err.find(says), std::string::npos) << says << " not in " << outcome.err;
    EXPECT_EQ(place.files(), before) << says;
  }
}

// A tooth of two shells, outside and nerve, in millimeters.
TEST(Drill, OpensATooth) {
  const Workplace place;
  const auto parts = cloudcontact::program::toothMeshes();
  place.write("tooth.obj",
              program_test::objText({{"Tooth0", parts[0].mesh}, {"Nerve", parts[2].mesh}}, 1e-3));
  const Outcome outcome = place.run({"drill", "tooth.obj", "--unit", "mm", "--tissue",
                                     "Tooth0=enamel", "--tissue", "Nerve=pulp", "--seconds", "1",
                                     "--bur", "sphere:0.0006", "--voxel", "0.0002", "--json"});
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  const json result = outcome.json();
  EXPECT_GT(result["cutVolume"].get<double>(), 0);
  EXPECT_NEAR(result["cutVolume"].get<double>(), result["workVolume"].get<double>(),
              0.03 * result["workVolume"].get<double>());
}

}  // namespace

}  // namespace prog_drill_test
