// Help, completion and the manual page: all of the same commands and options.
#include <gtest/gtest.h>

#include <cloudcontact/mesh/mesh.h>

#include <cstdlib>
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "program/obj_file.h"
#include "program/program_run.h"
#include "scene/primitive_mesh.h"

namespace prog_shell_test {
namespace {

namespace fs = std::filesystem;
using program_test::Outcome;
using program_test::Workplace;

// What the program lists under "Subcommands:".
std::vector<std::string> commands() {
  const Workplace place;
  std::istringstream help(place.run({"--help"}).out);
  std::vector<std::string> names;
  bool listed = false;
  for (std::string line; std::getline(help, line);) {
    if (line == "Subcommands:") listed = true;
    if (listed && line.size() > 2 && line.starts_with("  ") && line[2] != ' ')
      names.push_back(line.substr(2, line.find(' ', 2) - 2));
  }
  return names;
}

std::string helpOf(const std::string& command) {
  const Workplace place;
  return place.run({command, "--help"}).out;
}

std::set<std::string> optionsIn(const std::string& text) {
  static const std::regex option("(^|[ ,'\"])(--[a-z][a-z-]*)");
  std::set<std::string> names;
  for (std::sregex_iterator at(text.begin(), text.end(), option), end; at != end; ++at)
    names.insert((*at)[2]);
  return names;
}

// Options that stand at the beginning of a help's lines.
std::set<std::string> optionsOf(const std::string& command) {
  std::istringstream help(helpOf(command));
  std::string lines;
  for (std::string line; std::getline(help, line);)
    if (line.starts_with("  -")) lines += line.substr(0, 30) + "\n";
  return optionsIn(lines);
}

std::vector<std::string> examplesOf(const std::string& command) {
  std::istringstream help(helpOf(command));
  std::vector<std::string> lines;
  bool found = false;
  for (std::string line; std::getline(help, line);) {
    if (line == "Examples:") found = true;
    if (found && line.starts_with("  ")) lines.push_back(line.substr(2));
  }
  return lines;
}

int shell(const std::string& line) {
  return std::system(line.c_str());
}

TEST(Shell, EveryCommandHasExamplesOfItsOwn) {
  const std::vector<std::string> all = commands();
  EXPECT_GE(all.size(), 9u);
  // The laboratory, which is a program of its own, prints the help of `chart`.
  const fs::path laboratory =
      fs::path(CLOUDCONTACT_EXECUTABLE).parent_path() / "cloudcontact-chart";
  for (const std::string& command : all) {
    if (command == "chart" && !fs::exists(laboratory)) continue;
    const std::vector<std::string> lines = examplesOf(command);
    EXPECT_FALSE(lines.empty()) << command;
    const std::set<std::string> known = optionsOf(command);
    bool own = false;
    for (const std::string& line : lines) {
      own = own || line.starts_with("cloudcontact " + command);
      if (!line.starts_with("cloudcontact ")) continue;
      for (const std::string& option : optionsIn(line))
        EXPECT_TRUE(known.contains(option)) << command << ": " << line;
    }
    EXPECT_TRUE(own) << command;
  }
}

// What the examples name: boxes in millimeters, and a scene.
void writeFiles(const Workplace& place) {
  using namespace cloudcontact;
  const auto box = [](double edge) {
    return program_test::objText(
        {{"part", program::primitiveMesh(Box{Vec3::Constant(edge / 2)}, 0.01)}});
  };
  place.write("bolt.obj", box(10));
  place.write("nut.obj", box(6));
  place.write("tooth.obj", box(10));
  place.write("scene.sdf", R"(<sdf version="1.9"><world name="w"><model name="ball"><link name="l">
    <collision name="c"><geometry><sphere><radius>0.01</radius></sphere></geometry></collision>
    </link></model></world></sdf>)");
}

TEST(Shell, TheExamplesRun) {
  for (const std::string command : {"digitize", "contact", "simulate", "tune", "completion"}) {
    const Workplace place;
    writeFiles(place);
    for (std::string line : examplesOf(command)) {
      line = std::regex_replace(line, std::regex("^cloudcontact "), CLOUDCONTACT_EXECUTABLE " ");
      line = std::regex_replace(line, std::regex("(nut|bolt)\\.stl"), "$1.obj");
      line = "cd " + (place / "").string() + " && CLOUDCONTACT_CACHE=off " + line;
      if (line.find('>') == std::string::npos) line += " > out";
      EXPECT_EQ(shell(line + " 2> err"), 0) << line << "\n" << place.read("err");
    }
  }
}

TEST(Shell, CompletionAndManualNameAllCommandsAndOptions) {
  const Workplace place;
  for (const std::vector<std::string>& words : {std::vector<std::string>{"completion", "bash"},
                                                {"completion", "zsh"},
                                                {"completion", "fish"},
                                                {"manual"}}) {
    const Outcome outcome = place.run(words);
    EXPECT_EQ(outcome.exitCode, 0);
    const std::string text = std::regex_replace(outcome.out, std::regex("\\\\-"), "-");
    for (const std::string& command : commands()) {
      EXPECT_NE(text.find(command), std::string::npos) << words.back() << command;
      if (command == "chart") continue;  // its options are another program's, cloudcontact-chart's
      for (const std::string& option : optionsOf(command)) {
        const std::string name = words.back() == "fish" ? "-l " + option.substr(2) : option;
        EXPECT_NE(text.find(name), std::string::npos) << words.back() << ": " << command << option;
      }
    }
  }
  EXPECT_EQ(place.run({"completion", "tcsh"}).exitCode, 2);
}

// What bash offers where a line has these words.
std::string offered(const Workplace& place, const std::string& words, int at) {
  place.write("ask.sh", "source ./completion\nCOMP_WORDS=(" + words +
                            ")\nCOMP_CWORD=" + std::to_string(at) +
                            "\n_cloudcontact\necho \"${COMPREPLY[*]}\" > answer\n");
  EXPECT_EQ(shell("cd " + (place / "").string() + " && bash ask.sh"), 0);
  std::string answer = place.read("answer");
  if (!answer.empty()) answer.pop_back();
  return answer;
}

TEST(Shell, BashCompletesCommandsOptionsValuesAndFiles) {
  const Workplace place;
  place.write("completion", place.run({"completion", "bash"}).out);
  place.write("bolt.stl", "");
  EXPECT_EQ(offered(place, "cloudcontact sim", 1), "simulate");
  EXPECT_EQ(offered(place, "cloudcontact contact --stif", 2), "--stiffness");
  EXPECT_EQ(offered(place, "cloudcontact contact a b --backend o", 5), "opencl");
  EXPECT_EQ(offered(place, "cloudcontact contact --method gi", 3), "gimpact");
  EXPECT_EQ(offered(place, "cloudcontact completion z", 2), "zsh");
  EXPECT_EQ(offered(place, "cloudcontact contact bo", 2), "bolt.stl");
}

TEST(Shell, OtherShellsAndManReadThem) {
  const Workplace place;
  place.write("page", place.run({"manual"}).out);
  place.write("zsh", place.run({"completion", "zsh"}).out);
  place.write("fish", place.run({"completion", "fish"}).out);
  const std::string in = "cd " + (place / "").string() + " && ";
  if (shell("command -v zsh > /dev/null") == 0) {
    EXPECT_EQ(shell(in + "zsh -n zsh"), 0);
  }
  if (shell("command -v fish > /dev/null") == 0) {
    EXPECT_EQ(shell(in + "fish -n fish"), 0);
  }
  if (shell("command -v groff > /dev/null") == 0) {
    EXPECT_EQ(shell(in + "groff -man -Tascii -ww page > text 2> warnings"), 0);
    EXPECT_EQ(place.read("warnings"), "");
  }
}

}  // namespace

}  // namespace prog_shell_test
