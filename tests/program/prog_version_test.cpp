// `cloudcontact --version`: what is linked, and what this machine has.
#include <gtest/gtest.h>

#include <LinearMath/btScalar.h>
#include <cloudcontact/version.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "program/program_run.h"

namespace prog_version_test {
namespace {

std::vector<std::string> versionLines() {
  const program_test::Workplace place;
  const program_test::Outcome outcome = place.run({"--version"});
  EXPECT_EQ(outcome.exitCode, 0);
  EXPECT_EQ(outcome.err, "");
  std::istringstream text(outcome.out);
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

// The flags that Linux found in the processor.
std::string processorFlags() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.rfind("flags", 0) == 0) return line + " ";
  return "";
}

TEST(Version, NamesWhatIsLinked) {
  const std::vector<std::string> lines = versionLines();
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[0], "cloudcontact " CLOUDCONTACT_VERSION);
  EXPECT_EQ(cloudcontact::version(), CLOUDCONTACT_VERSION);
  std::ostringstream bullet;
  bullet << "Bullet " << btGetVersion() / 100 << '.' << btGetVersion() / 10 % 10
         << btGetVersion() % 10 << " in float";
  EXPECT_EQ(lines[1], bullet.str());
}

TEST(Version, NamesTheWidestInstructionsThatTheProcessorHas) {
  const std::string line = versionLines().at(2), flags = processorFlags();
  const auto has = [&](const char* flag) {
    return flags.find(std::string(" ") + flag + " ") != std::string::npos;
  };
  if (flags.empty() || line == "vector instructions: baseline") {
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    EXPECT_FALSE(has("avx2") && has("fma") && has("bmi2"));
#endif
    return;
  }
  const bool widest = has("avx512f") && has("avx512bw") && has("avx512dq") && has("avx512vl");
  EXPECT_EQ(line, std::string("vector instructions: ") + (widest ? "AVX-512" : "AVX2"));
}

TEST(Version, ListsDevices) {
  const std::string line = versionLines().at(3);
  EXPECT_EQ(line.rfind("OpenCL devices: ", 0), 0u) << line;
  if (std::getenv("CLOUDCONTACT_NEEDS_OPENCL")) {
    EXPECT_NE(line, "OpenCL devices: none");
  }
}

}  // namespace

}  // namespace prog_version_test
