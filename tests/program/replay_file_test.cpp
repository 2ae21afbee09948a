// `--replay`: the file as read by another library, bad input, and no incomplete files.
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <assimp/Importer.hpp>
#include <cmath>
#include <csignal>
#include <fstream>
#include <map>
#include <sstream>

#include "program/program_run.h"

namespace cloudcontact::program::replay_file_test {
namespace {

using program_test::Outcome;
using program_test::Workplace;

// A box tumbles onto a plane next to a ball; an L of two boxes is fixed.
constexpr const char* kScene = R"(<?xml version="1.0"?>
<sdf version="1.9"><world name="tumble &amp; &lt;/script&gt;"><gravity>0 0 -9.8</gravity>
<physics name="p" type="bullet"><max_step_size>0.005</max_step_size>
<real_time_factor>0</real_time_factor></physics>
<model name="floor"><static>true</static><link name="l"><collision name="c">
<geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model>
<model name="brick"><pose>0 0 0.5 0.3 0.2 0.1</pose><link name="l"><inertial><mass>1</mass></inertial>
<collision name="c"><geometry><box><size>0.2 0.3 0.2</size></box></geometry>
<surface><friction><ode><mu>0.5</mu></ode></friction></surface></collision></link></model>
<model name="ball"><pose>0.5 0 0.3 0 0 0</pose><link name="l"><inertial><mass>1</mass></inertial>
<collision name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision></link></model>
<model name="ell"><static>true</static><pose>-0.6 0 0.1 0 0 0.4</pose><link name="l">
<collision name="a"><geometry><box><size>0.1 0.1 0.2</size></box></geometry></collision>
<collision name="b"><pose>0.1 0 0 0 0 0</pose><geometry><box><size>0.1 0.1 0.1</size></box></geometry>
</collision></link></model></world></sdf>)";

class ReplayFile : public ::testing::Test {
 protected:
  ReplayFile() { place.write("scene.sdf", kScene); }
  Outcome simulate(std::vector<std::string> more) {
    std::vector<std::string> words = {"simulate", "scene.sdf", "--seconds", "1", "--voxel", "0.02"};
    words.insert(words.end(), more.begin(), more.end());
    return place.run(words);
  }
  Workplace place;
};

struct Row {
  double time;
  aiVector3D position;
  aiQuaternion turn;
};

std::map<std::string, std::vector<Row>> trajectory(const std::string& csv) {
  std::map<std::string, std::vector<Row>> rows;
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    std::vector<double> n;
    for (std::size_t i = 2; i < cells.size(); ++i) n.push_back(std::stod(cells[i]));
    rows[cells[1]].push_back({std::stod(cells[0]),
                              {float(n[0]), float(n[1]), float(n[2])},
                              {float(n[6]), float(n[3]), float(n[4]), float(n[5])}});
  }
  return rows;
}

// Interpolates Assimp's keys as glTF does.
aiVector3D placeAt(const aiNodeAnim& channel, double ticks) {
  unsigned i = 0;
  while (i + 2 < channel.mNumPositionKeys && channel.mPositionKeys[i + 1].mTime < ticks) ++i;
  const aiVectorKey &a = channel.mPositionKeys[i], &b = channel.mPositionKeys[i + 1];
  const auto share = ai_real((ticks - a.mTime) / (b.mTime - a.mTime));
  return a.mValue + share * (b.mValue - a.mValue);
}

aiQuaternion turnAt(const aiNodeAnim& channel, double ticks) {
  unsigned i = 0;
  while (i + 2 < channel.mNumRotationKeys && channel.mRotationKeys[i + 1].mTime < ticks) ++i;
  const aiQuatKey &a = channel.mRotationKeys[i], &b = channel.mRotationKeys[i + 1];
  aiQuaternion out;
  aiQuaternion::Interpolate(out, a.mValue, b.mValue,
                            ai_real((ticks - a.mTime) / (b.mTime - a.mTime)));
  return out;
}

// Angle between two quaternions of any sign.
double apart(const aiQuaternion& p, const aiQuaternion& q) {
  double minus = 0, plus = 0;
  for (const auto& [a, b] : {std::pair(p.w, q.w), {p.x, q.x}, {p.y, q.y}, {p.z, q.z}}) {
    minus += (a - b) * (a - b);
    plus += (a + b) * (a + b);
  }
  return std::sqrt(std::min(minus, plus));
}

TEST_F(ReplayFile, AnotherReaderFindsTheTrajectoryInIt) {
  // Runs until the brick is at rest: a tumbling body needs a key for every state.
  ASSERT_EQ(place
                .run({"simulate", "scene.sdf", "--seconds", "3", "--voxel", "0.02", "--replay",
                      "out.glb", "--trajectory", "out.csv"})
                .exitCode,
            0);
  const auto rows = trajectory(place.read("out.csv"));
  Assimp::Importer importer;
  const aiScene* scene =
      importer.ReadFile((place / "out.glb").string(), aiProcess_ValidateDataStructure);
  ASSERT_NE(scene, nullptr) << importer.GetErrorString();
  ASSERT_EQ(scene->mNumAnimations, 1u);
  const aiAnimation& motion = *scene->mAnimations[0];
  EXPECT_EQ(motion.mNumChannels, 2u);  // the brick and the ball; nothing else moves
  const double size = 1.2;             // of the scene [m]
  for (unsigned c = 0; c < motion.mNumChannels; ++c) {
    const aiNodeAnim& channel = *motion.mChannels[c];
    const auto body = rows.find(channel.mNodeName.C_Str());
    ASSERT_NE(body, rows.end()) << channel.mNodeName.C_Str();
    ASSERT_GT(channel.mNumPositionKeys, 5u);
    EXPECT_LT(201 * channel.mNumPositionKeys, 190 * body->second.size());  // thinned
    for (int k = 0; k <= 10; ++k) {
      const Row& row = body->second[std::size_t(k) * (body->second.size() - 1) / 10];
      const double ticks = row.time * motion.mTicksPerSecond;
      EXPECT_LT((placeAt(channel, ticks) - row.position).Length(), 1e-4 * size) << row.time;
      // 4 sin(angle / 4), for a body whose corners are 0.25 m away.
      EXPECT_LT(2 * apart(turnAt(channel, ticks), row.turn) * 0.25, 1e-4 * size) << row.time;
    }
  }
}

// Positions and sizes as in the scene, with z up turned to y up.
TEST_F(ReplayFile, BodiesStandWhereTheyAre) {
  ASSERT_EQ(simulate({"--replay", "out.glb"}).exitCode, 0);
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile((place / "out.glb").string(), 0);
  ASSERT_NE(scene, nullptr);
  EXPECT_EQ(scene->mNumMeshes, 5u);  // floor, brick, ball, the two boxes of the ell
  const aiNode* ell = scene->mRootNode->FindNode("ell");
  ASSERT_NE(ell, nullptr);
  EXPECT_EQ(ell->mNumChildren, 2u);
  aiMatrix4x4 whole;
  for (const aiNode* node = ell; node; node = node->mParent) whole = node->mTransformation * whole;
  const aiVector3D origin = whole * aiVector3D(0, 0, 0), up = whole * aiVector3D(0, 0, 1) - origin;
  EXPECT_NEAR(origin.x, -0.6, 1e-5);
  EXPECT_NEAR(origin.y, 0.1, 1e-5);
  EXPECT_NEAR(up.y, 1, 1e-5);
  const aiVector3D along = whole * aiVector3D(1, 0, 0) - origin;
  EXPECT_NEAR(along.x, std::cos(0.4), 1e-5);
  EXPECT_NEAR(along.z, -std::sin(0.4), 1e-5);
  const aiNode* ball = scene->mRootNode->FindNode("ball (mesh)");
  ASSERT_TRUE(ball != nullptr && ball->mNumMeshes == 1);
  const aiMesh& sphere = *scene->mMeshes[ball->mMeshes[0]];
  ASSERT_GT(sphere.mNumVertices, 100u);
  for (unsigned i = 0; i < sphere.mNumVertices; ++i)
    EXPECT_NEAR(sphere.mVertices[i].Length(), 0.1, 0.002);
}

TEST_F(ReplayFile, APageNeedsNoOtherFile) {
  ASSERT_EQ(simulate({"--replay", "out.html"}).exitCode, 0);
  const std::string page = place.read("out.html");
  EXPECT_EQ(page.rfind("<!doctype html>", 0), 0u);
  // The scene's name is escaped.
  EXPECT_NE(page.find("<title>tumble &amp; &lt;/script></title>"), std::string::npos);
  for (const char* outside : {"src=\"", "href=\"", "@import", "url(http"})
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  EXPECT_EQ(page.find("{{"), std::string::npos) << "a mark was left in the template";
}

TEST_F(ReplayFile, TheSameRunIsTheSameFile) {
  ASSERT_EQ(simulate({"--replay", "a.glb"}).exitCode, 0);
  ASSERT_EQ(simulate({"--replay", "b.glb"}).exitCode, 0);
  EXPECT_EQ(place.read("a.glb"), place.read("b.glb"));
  // Recording does not change the simulation.
  const auto watched = simulate({"--replay", "c.html", "--json"}).json();
  EXPECT_EQ(watched["hash"], simulate({"--json"}).json()["hash"]);
}

struct Refusal {
  const char *file, *words;
};
class RefusedReplay : public ReplayFile, public testing::WithParamInterface<Refusal> {};

TEST_P(RefusedReplay, SaysWhyAndLeavesNothing) {
  std::filesystem::create_directory(place / "folder.glb");
  const auto before = place.files();
  const Outcome outcome = simulate({"--replay", GetParam().file});
  EXPECT_EQ(outcome.exitCode, 2);
  EXPECT_EQ(outcome.out, "");
  EXPECT_NE(outcome.err.find(GetParam().words), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("--replay"), std::string::npos) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_EQ(place.files(), before);
}
INSTANTIATE_TEST_SUITE_P(Files, RefusedReplay,
                         ::testing::Values(Refusal{"out.mp4", "neither .glb nor .html"},
                                           Refusal{"out", "neither .glb nor .html"},
                                           Refusal{"nowhere/out.glb", "folder does not exist"},
                                           Refusal{"folder.glb", "is a directory"},
                                           Refusal{"/proc/out.html", "folder is not writable"}));

TEST_F(ReplayFile, OfNoDemoIsRefused) {
  const Outcome outcome = place.run({"demo", "--replay", "out.glb"});
  EXPECT_EQ(outcome.exitCode, 2);
  EXPECT_NE(outcome.err.find("give its name"), std::string::npos) << outcome.err;
}

// A limit on the size of files simulates a full disk: the old file stays, and no other is left.
TEST_F(ReplayFile, AFullDiskLeavesTheOldFile) {
  for (const char* name : {"out.glb", "out.html"}) {
    place.write(name, "old");
    const auto before = place.files();
    rlimit all{};
    getrlimit(RLIMIT_FSIZE, &all);
    rlimit little = all;
    little.rlim_cur = 4096;
    const auto kept = std::signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &little);
    const Outcome outcome = simulate({"--replay", name});
    setrlimit(RLIMIT_FSIZE, &all);
    std::signal(SIGXFSZ, kept);
    EXPECT_EQ(outcome.exitCode, 1) << outcome.err;
    EXPECT_NE(outcome.err.find("could not be written whole"), std::string::npos) << outcome.err;
    EXPECT_EQ(place.files(), before);
    EXPECT_EQ(place.read(name), "old");
  }
}

// Every method can write a replay.
TEST_F(ReplayFile, BulletsMethodsHaveReplaysToo) {
  for (const char* method : {"primitive", "gjk"}) {
    const Outcome outcome = simulate({"--replay", "out.html", "--method", method});
    EXPECT_EQ(outcome.exitCode, 0) << method << outcome.err;
  }
}

}  // namespace
}  // namespace cloudcontact::program::replay_file_test
