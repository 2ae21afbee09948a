// Bad input of every kind gives exit code 2, one line on stderr that names the file or option and
// says what to do, nothing on stdout, and no new file.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "program/program_run.h"

namespace prog_bad_input_test {
namespace {

using program_test::Outcome;
using program_test::Workplace;

const char* const kTetrahedron =
    "v 0 0 0\nv 0.01 0 0\nv 0 0.01 0\nv 0 0 0.01\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

// A binary STL whose header promises more triangles than follow.
std::string truncatedStl() {
  std::string stl(84 + 50, '\0');
  const std::uint32_t promised = 12;
  std::memcpy(stl.data() + 80, &promised, sizeof promised);
  return stl;
}

void writeFiles(const Workplace& place) {
  place.write("good.obj", kTetrahedron);
  place.write("empty.stl", "");
  place.write("empty.obj", "");
  place.write("cut.stl", truncatedStl());
  place.write("words.stl", "this is no mesh at all, only words in a file\n");
  place.write("vertices.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
  place.write("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n");
  place.write("range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
  place.write("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
  place.write("broken.gltf", "{\"asset\": {\"version\": \"2.0\"}, \"meshes\": [");
  place.write("points.ply",
              "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
              "property float z\nend_header\n0 0 0\n");
  place.write("points.pcd", "VERSION .7\n");
  place.write("points.xyz", "0 0 0\n1 1 1\n");
  place.write("nan.xyz", "0 0 0\n1 nan 1\n");
  std::string open;
  for (int k = 0; k < 100; ++k)
    open += std::to_string(k % 10 * 0.001) + ' ' + std::to_string(k / 10 * 0.001) + " 0\n";
  place.write("open.xyz", open);
  place.write("what.foo", "foo\n");
  place.write("empty.cloud", "");
  place.write("words.cloud", "these are words, not voxels, and there are enough of them here\n");
  std::filesystem::create_directory(place / "folder");
  std::filesystem::create_directory(place / "folder.cloud");
}

// Worlds with a ball and an error each.
void writeScenes(const Workplace& place) {
  const auto scene = [](const std::string& geometry) {
    return "<?xml version='1.0'?><sdf version='1.9'><world name='w'><gravity>0 0 -9.81</gravity>"
           "<physics name='p' type='bullet'><max_step_size>0.004</max_step_size></physics>"
           "<model name='ball'><link name='l'><inertial><mass>1</mass></inertial>"
           "<collision name='c'><geometry>" +
           geometry + "</geometry></collision></link></model></world></sdf>";
  };
  const std::string ball = scene("<sphere><radius>0.1</radius></sphere>");
  place.write("ball.sdf", ball);
  place.write("empty.sdf", "");
  place.write("cut.sdf", ball.substr(0, ball.size() / 2));
  place.write("negative.sdf", scene("<sphere><radius>-0.1</radius></sphere>"));
  const auto with = [&](const std::string& element) {
    std::string text = ball;
    return text.insert(text.find("</collision>"), element);
  };
  place.write("stiff.sdf", with("<surface><contact><ode><kp>1e300</kp></ode></contact></surface>"));
  place.write("damped.sdf",
              with("<surface><contact><ode><kd>1e300</kd></ode></contact></surface>"));
  place.write("meshless.sdf", scene("<mesh><uri>gone.obj</uri></mesh>"));
}

// Damaged cloud files.
void writeClouds(const Workplace& place) {
  const Outcome saved =
      place.run({"digitize", "sphere:0.01", "--voxel", "0.001", "-o", "good.cloud"});
  ASSERT_EQ(saved.exitCode, 0) << saved.err;
  const std::string good = place.read("good.cloud");
  place.write("cut.cloud", good.substr(0, good.size() / 2));
  place.write("long.cloud", good + "more");
  std::string other = good;
  other[0] = static_cast<char>(other[0] ^ 1);
  place.write("other.cloud", other);
}

struct Case {
  std::vector<std::string> arguments;
  std::vector<std::string> inMessage;  // all of them
};

std::vector<Case> fileCases() {
  std::vector<Case> cases;
  const auto add = [&](const char* file, std::vector<std::string> words) {
    words.push_back(file);
    cases.push_back({{"digitize", file, "--voxel", "0.001"}, std::move(words)});
  };
  add("missing.obj", {"no such file", "give"});
  add("folder", {"directory"});
  add("empty.stl", {"empty"});
  add("empty.obj", {"empty"});
  add("cut.stl", {"cut short"});
  add("words.stl", {"STL"});
  add("vertices.obj", {});
  add("nan.obj", {"NaN"});
  add("range.obj", {"range"});
  add("line.obj", {"volume"});
  add("broken.gltf", {});
  add("points.ply", {"16 points"});
  add("points.pcd", {"PCD", "DATA"});
  add("points.xyz", {"16 points"});
  add("nan.xyz", {"point 1 is NaN"});
  add("open.xyz", {"close no volume", "--shell"});
  add("what.foo", {});
  add("empty.cloud", {"cut short"});
  add("words.cloud", {"not a cloud"});
  add("cut.cloud", {"cut short"});
  add("long.cloud", {"too many"});
  add("other.cloud", {"not a cloud"});
  return cases;
}

std::vector<Case> primitiveCases() {
  std::vector<Case> cases;
  for (const char* form :
       {"sphere", "sphere:", "sphere:-1", "sphere:0", "sphere:wide", "sphere:1,2", "sphere:1,",
        "sphere:nan", "sphere:1e30", "box:1,2", "box:1,2,inf", "box:1 2 3", "cylinder:0,1",
        "capsule:1", "cone:1,-1", "halfspace:1", "cube:1"})
    cases.push_back({{"digitize", form}, {form}});
  cases.push_back({{"digitize", "halfspace"}, {"halfspace", "give a box"}});
  return cases;
}

std::vector<Case> optionCases() {
  const auto digitize = [](std::vector<std::string> rest) {
    rest.insert(rest.begin(), {"digitize", "sphere:0.01"});
    return rest;
  };
  return {
      {digitize({"--voxel", "0"}), {"--voxel", "'0'", "greater than 0"}},
      {digitize({"--voxel", "-0.001"}), {"--voxel", "greater than 0"}},
      {digitize({"--voxel", "nan"}), {"--voxel", "'nan'", "finite"}},
      {digitize({"--voxel", "inf"}), {"--voxel", "finite"}},
      {digitize({"--voxel", "1mm"}), {"--voxel", "'1mm'"}},
      {digitize({"--voxel", ""}), {"--voxel"}},
      {digitize({"--voxel"}), {"--voxel", "--help"}},
      {digitize({"--voxel", "1e-7"}), {"--voxel", "sphere:0.01", "MB", "or larger"}},
      {digitize({"--voxel", "1e-300"}), {"--voxel", "or larger"}},
      {digitize({"--voxel", "1"}), {"--voxel", "give at most"}},
      {digitize({"--unit", "ft"}), {"--unit", "'ft'", "mm, cm, in, m"}},
      {digitize({"--shell", "0"}), {"--shell"}},
      {digitize({"--density", "-1"}), {"--density"}},
      {digitize({"--threads", "-1"}), {"--threads", "0 to 1024"}},
      {digitize({"--threads", "many"}), {"--threads", "'many'"}},
      {digitize({"--backend", "cuda"}), {"--backend", "cpu, opencl"}},
      {digitize({"--material", "steel"}), {"--material", "--help"}},
      {digitize({"--law", "paper"}), {"--law", "--help"}},
      {digitize({"--friction", "0.3"}), {"--friction", "--help"}},
      {digitize({"--stiffness", "1"}), {"--stiffness", "--help"}},
      {digitize({"--method", "cloud"}), {"--method", "--help"}},
      {digitize({"--tissues", "dental"}), {"--tissues", "--help"}},
      {{"drill", "sphere:0.01", "--law", "paper"}, {"--law", "--help"}},
      {{"drill", "sphere:0.01", "--friction", "0.3"}, {"--friction", "--help"}},
      {{"drill", "sphere:0.01", "--damping", "1"}, {"--damping", "--help"}},
      {{"drill", "sphere:0.01", "--method", "cloud"}, {"--method", "--help"}},
      {{"drill", "sphere:0.01", "--backend", "cpu"}, {"--backend", "--help"}},
      {{"drill", "sphere:0.01", "--window", "sphere:1"}, {"--window", "--help"}},
      {digitize({"-o", "cloud.stl"}), {"-o", "cloud.stl", ".cloud"}},
      {digitize({"-o", "nowhere/a.cloud"}), {"-o", "nowhere/a.cloud", "folder"}},
      {digitize({"-o", "folder.cloud"}), {"-o", "folder.cloud", "directory"}},
      {digitize({"-o", ""}), {"-o", "empty"}},
      {digitize({"--speed", "9"}), {"--speed", "--help"}},
      {{"digitize"}, {"BODY", "--help"}},
      {{"digitize", "good.cloud", "--voxel", "0.002"}, {"--voxel", "good.cloud"}},
      {{"digest"}, {"'digest'", "digitize, contact, simulate, demo"}},
      {{}, {"no command", "digitize, contact, simulate, demo"}},
  };
}

std::vector<Case> contactCases() {
  const auto contact = [](std::vector<std::string> rest) {
    rest.insert(rest.begin(), {"contact", "halfspace", "sphere:0.01", "--voxel", "0.001"});
    return rest;
  };
  const auto posed = [&](std::vector<std::string> rest) {
    rest.insert(rest.end(), {"--pose", "0 0 0.0099"});
    return contact(std::move(rest));
  };
  const auto paper = [&](std::vector<std::string> rest) {
    rest.insert(rest.end(), {"--method", "paper"});
    return posed(std::move(rest));
  };
  const auto tissues = [&](std::vector<std::string> rest) {
    rest.insert(rest.end(), {"--tissues", "dental"});
    return posed(std::move(rest));
  };
  return {
      {contact({}), {"--pose"}},
      {contact({"--pose", "1 2"}), {"--pose", "'1 2'", "x y z qx qy qz qw"}},
      {contact({"--pose", "a b c"}), {"--pose"}},
      {contact({"--pose", "0 0 nan"}), {"--pose"}},
      {contact({"--pose", "0 0 1e300"}), {"--pose"}},
      {contact({"--pose", "0 0 0 0 0 0 0"}), {"--pose", "length 1"}},
      {contact({"--pose", "0 0 0 0 0 0 1 2"}), {"--pose"}},
      {posed({"--velocity", "1 2 3"}), {"--velocity", "vx vy vz wx wy wz"}},
      {posed({"--velocity", "0 0 inf 0 0 0"}), {"--velocity"}},
      {posed({"--repeat", "0"}), {"--repeat", "1 to"}},
      {posed({"--method", "magic"}),
       {"--method", "cloud, paper, gjk, gimpact, hacd, primitive, sdf"}},
      {posed({"--method", "sdf"}), {"--method sdf"}},
      {posed({"--law", "newton"}), {"--law", "paper, foundation"}},
      {posed({"--law", "rigid"}), {"--law rigid"}},
      {posed({"--law", "maxwell:1,2"}), {"--law", "simulate"}},
      {posed({"--law", "maxwell:1"}), {"--law", "maxwell:K,C"}},
      {posed({"--law", "solid:1,2,-3"}), {"--law", "solid:K,K1,C1"}},
      {posed({"--law", "water:1,2"}), {"--law", "maxwell:K,C"}},
      {posed({"--law", "foundation", "--method", "gjk"}), {"--law foundation", "cloud"}},
      {posed({"--stiffness", "0"}), {"--stiffness"}},
      {posed({"--stiffness", "1e300"}), {"--stiffness", "1e30"}},
      {posed({"--velocity", ""}), {"--velocity", "empty"}},
      {posed({"--damping", "-1"}), {"--damping"}},
      {posed({"--friction", "0.3"}), {"--friction", "--help"}},
      {posed({"--window", "sphere:0.003"}), {"--window", "--method paper"}},
      {posed({"--representative", "0 0 0"}), {"--representative", "--method paper"}},
      {posed({"--hardness"}), {"--hardness", "--method paper"}},
      {posed({"--area-a", "sphere:0.003"}), {"--area-a", "--method paper"}},
      {posed({"--area-b", "sphere:0.003"}), {"--area-b", "--method paper"}},
      {paper({"--window", "cube:1"}), {"--window", "ellipsoid:X,Y,Z"}},
      {paper({"--window", "cylinder:1,1"}), {"--window", "ellipsoid:X,Y,Z"}},
      {paper({"--window", "box:1,1"}), {"--window", "wrong number"}},
      {paper({"--window", "sphere:-1"}), {"--window", "greater than 0"}},
      {paper({"--window", "sphere:0.00001"}), {"--window", "take a larger one"}},
      {paper({"--window", "sphere:0.1"}), {"--window", "take a smaller one"}},
      {paper({"--representative", "0 0"}), {"--representative", "x y z"}},
      {paper({"--hardness"}), {"--hardness", "--tissues"}},
      {paper({"--area-a", "sphere:0.01"}), {"--area-a", "half-space"}},
      {paper({"--area-b", "halfspace"}), {"--area-b", "half-space"}},
      {paper({"--area-b", "gone.obj"}), {"gone.obj", "no such file"}},
      {posed({"--tissue", "all=enamel"}), {"--tissue", "--tissues"}},
      {posed({"--tissues", "dental"}), {"--tissues", "--tissue", "enamel"}},
      {posed({"--tissues", "soup"}), {"--tissues", "dental"}},
      {tissues({"--tissue", "lid=enamel"}), {"--tissue", "lid", "all"}},
      {tissues({"--tissue", "all=iron"}), {"iron", "enamel"}},
      {tissues({"--tissue", "all"}), {"--tissue", "PART=TISSUE"}},
      {tissues({"--tissue", "all=enamel", "--tissue", "all=pulp"}), {"--tissue", "all", "twice"}},
      {tissues({"--tissue", "all=enamel", "--stiffness", "1"}), {"--stiffness", "--tissues"}},
      {tissues({"--tissue", "all=enamel", "--damping", "1"}), {"--damping", "--tissues"}},
      {tissues({"--tissue", "all=enamel", "--method", "gjk"}), {"--tissues", "--method cloud"}},
      {{"contact", "halfspace", "halfspace", "--pose", "0 0 0"}, {"halfspace"}},
      {{"contact", "halfspace", "good.obj", "--pose", "0 0 0", "--method", "primitive"},
       {"--method primitive", "good.obj"}},
      {{"contact", "halfspace", "good.cloud", "--pose", "0 0 0", "--method", "gjk"},
       {"good.cloud", "--method cloud"}},
      {{"contact", "sphere:0.01", "--pose", "0 0 0"}, {"B", "--help"}},
  };
}

std::vector<Case> simulateCases() {
  const auto simulate = [](std::vector<std::string> rest) {
    rest.insert(rest.begin(), {"simulate", "ball.sdf", "--voxel", "0.02"});
    return rest;
  };
  return {
      {{"simulate"}, {"--help"}},
      {{"simulate", "gone.sdf"}, {"gone.sdf", "no such file"}},
      {{"simulate", "folder"}, {"folder", "is a directory"}},
      {{"simulate", "good.obj"}, {"good.obj", "SDFormat"}},
      {{"simulate", "empty.sdf"}, {"empty.sdf", "SDFormat"}},
      {{"simulate", "cut.sdf"}, {"cut.sdf", "cut short"}},
      {{"simulate", "meshless.sdf"}, {"meshless.sdf", "'ball'", "gone.obj"}},
      {{"simulate", "negative.sdf"}, {"negative.sdf", "'ball'", "<radius>"}},
      {{"simulate", "stiff.sdf"}, {"stiff.sdf", "'ball'", "stiffness", "1e30"}},
      {{"simulate", "damped.sdf"}, {"damped.sdf", "'ball'", "damping", "1e30"}},
      {{"simulate", "ball.sdf", "--window", "sphere:0.1"}, {"--window", "--method paper"}},
      {{"simulate", "/dev/zero"}, {"/dev/zero", "not a file"}},
      {{"simulate", "ball.sdf", "--voxel", "1e-9", "--tolerance", "exact"},
       {"'ball'", "--voxel", "or larger"}},
      {simulate({"--trajectory", ""}), {"--trajectory", "empty"}},
      {simulate({"--replay="}), {"--replay", "empty"}},
      {simulate({"--seconds", "nan"}), {"--seconds"}},
      {simulate({"--step", "0"}), {"--step"}},
      {simulate({"--step", "1e-12"}), {"--step", "longer"}},
      {simulate({"--substeps", "0"}), {"--substeps"}},
      {simulate({"--iterations", "few"}), {"--iterations", "'few'"}},
      {simulate({"--trajectory", "nowhere/a.csv"}), {"--trajectory", "nowhere/a.csv"}},
      {simulate({"--trajectory", "folder"}), {"--trajectory", "folder"}},
      {simulate({"--replay", "a.mp4"}), {"--replay", "neither .glb nor .html"}},
      {simulate({"--method", "sdf"}), {"--method sdf", "use"}},
      {simulate({"--window", "sphere:0.1"}), {"--window", "--method paper"}},
      {simulate({"--method", "paper", "--window", "sphere:0.0001"}), {"'ball'", "larger"}},
      {simulate({"--method", "paper", "--area-a", "sphere:0.1"}), {"--area-a", "--help"}},
      {simulate({"--method", "paper", "--hardness"}), {"--hardness", "--tissues"}},
      {simulate({"--tissue", "all=enamel"}), {"--tissue", "--tissues"}},
      {simulate({"--tissues", "dental"}), {"--tissues", "enamel"}},
      {simulate({"--tissues", "dental", "--tissue", "lid=enamel"}), {"--tissue", "lid"}},
      {simulate({"--tissues", "dental", "--tissue", "all=enamel", "--stiffness", "1"}),
       {"--stiffness", "--tissues"}},
      {simulate({"--tissues", "dental", "--tissue", "all=enamel", "--law", "rigid"}),
       {"--law", "--tissues"}},
      {simulate({"--tissues", "dental", "--tissue", "all=enamel", "--method", "gjk"}),
       {"--tissues", "--method cloud"}},
      {{"demo", "nothing"}, {"nothing"}},
  };
}

std::string inWords(const Case& c) {
  std::string words = "cloudcontact";
  for (const std::string& a : c.arguments) words += " '" + a + "'";
  return words;
}

class BadInput : public ::testing::Test {
 protected:
  void SetUp() override {
    writeFiles(place);
    writeScenes(place);
    writeClouds(place);
  }

  void expectRefused(const std::vector<Case>& cases) {
    const std::set<std::string> before = place.files();
    for (const Case& c : cases) {
      SCOPED_TRACE(inWords(c));
      const Outcome outcome = place.run(c.arguments);
      EXPECT_EQ(outcome.exitCode, 2) << outcome.err;
      EXPECT_EQ(outcome.out, "");
      EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
      EXPECT_EQ(outcome.err.rfind("cloudcontact: ", 0), 0U) << outcome.err;
      EXPECT_NE(outcome.err.find(';'), std::string::npos) << "says what to do: " << outcome.err;
      for (const std::string& word : c.inMessage)
        EXPECT_NE(outcome.err.find(word), std::string::npos) << word << " not in " << outcome.err;
      EXPECT_EQ(place.files(), before);
    }
  }

  Workplace place;
};

TEST_F(BadInput, FilesAreRefusedByName) {
  expectRefused(fileCases());
}
TEST_F(BadInput, PrimitivesAreRefusedByName) {
  expectRefused(primitiveCases());
}
TEST_F(BadInput, OptionsAreRefusedByName) {
  expectRefused(optionCases());
}
TEST_F(BadInput, ContactsAreRefusedByName) {
  expectRefused(contactCases());
}
TEST_F(BadInput, SimulationsAreRefusedByName) {
  expectRefused(simulateCases());
}

// Guards against a program that rejects everything.
TEST_F(BadInput, GoodInputIsNotRefused) {
  const std::vector<std::vector<std::string>> good = {
      {"digitize", "good.obj", "--voxel", "0.0005"},
      {"digitize", "good.obj", "--unit", "mm"},
      {"digitize", "good.cloud"},
      {"digitize", "good.cloud", "--voxel", "0.001"},
      {"digitize", "capsule:0.01,0.02", "--voxel", "+1e-3", "--threads", "1"},
      {"contact", "halfspace", "good.cloud", "--pose", "0 0 -0.0 0 0 0 1", "--repeat", "1"},
      {"contact", "cone:0.01,0.02", "sphere:0.01", "--pose", "-1 0 0", "--voxel", "0.001"},
      {"contact", "halfspace", "sphere:0.01", "--pose", "0 0 0.0099", "--voxel", "0.001",
       "--backend", "opencl"},
      {"simulate", "ball.sdf", "--voxel", "0.02", "--seconds", "0.01"},
      {"--help"},
      {"contact", "--help"},
      {"--version"},
  };
  for (const auto& arguments : good) {
    SCOPED_TRACE(inWords({arguments, {}}));
    const Outcome outcome = place.run(arguments);
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    EXPECT_NE(outcome.out, "");
  }
}

// Sanitizers reserve address space without end.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// A body that needs more memory than there is, is bad input. The limit is of address space; the
// body needs more than a gigabyte.
TEST_F(BadInput, NamesTheBodyThatNeedsTooMuchMemory) {
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &before), 0);
  rlimit few = before;
  few.rlim_cur = 400u << 20;
  const std::string body = "box:0.1,0.1,0.1";
  ASSERT_EQ(setrlimit(RLIMIT_AS, &few), 0);
  const Outcome outcome = place.run({"digitize", body, "--voxel", "0.0001", "--threads", "1"});
  ASSERT_EQ(setrlimit(RLIMIT_AS, &before), 0);
  EXPECT_EQ(outcome.exitCode, 2) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_NE(outcome.err.find(body + ": needs more memory"), std::string::npos) << outcome.err;
}
#endif

// Results that are lost are work that failed.
TEST_F(BadInput, LostResultsAreNoSuccess) {
  const std::string program = CLOUDCONTACT_EXECUTABLE;
  for (const char* words : {" digitize sphere:0.01 --voxel 0.002 --json", " demo", " --version"}) {
    const int status = std::system((program + words + " > /dev/full 2> /dev/null").c_str());
    EXPECT_EQ(WEXITSTATUS(status), 1) << words;
  }
}

// A failed write leaves the old file unchanged.
TEST_F(BadInput, AFailedSaveKeepsTheOldFile) {
  const std::string before = place.read("good.cloud");
  const Outcome outcome =
      place.run({"digitize", "sphere:0.01", "--voxel", "1e-300", "-o", "good.cloud"});
  EXPECT_EQ(outcome.exitCode, 2);
  EXPECT_EQ(place.read("good.cloud"), before);
}

}  // namespace

}  // namespace prog_bad_input_test
