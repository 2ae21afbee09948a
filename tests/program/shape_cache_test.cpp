// Clouds and fields kept between runs.
#include "scene/shape_cache.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <vector>

#include <cloudcontact/voxels/digitize.h>

#include "program/program_run.h"
#include "scene/primitive_mesh.h"

namespace shape_cache_test {
namespace {

using namespace cloudcontact;
using namespace cloudcontact::program;
namespace fs = std::filesystem;
using program_test::Workplace;

constexpr double kVoxel = 0.001;

Mesh ball(double radius) {
  return primitiveMesh(Sphere{radius}, 1e-5);
}

// A cache's answers, and how often it had to make one.
struct Kept {
  ShapeCache cache;
  int made = 0;

  Cloud cloud(const Mesh& mesh, double voxel = kVoxel) {
    return cache.cloud(mesh, voxel, [&] {
      ++made;
      DigitizeSettings settings;
      settings.voxelSize = voxel;
      return digitize(mesh, settings);
    });
  }
  std::uint64_t field(const Mesh& mesh) {
    const Cloud voxels = cloud(mesh);
    return cache
        .field(voxels,
               [&] {
                 ++made;
                 return SurfaceField::build(voxels);
               })
        ->hash();
  }
};

std::vector<fs::path> entries(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  return files;
}

std::uintmax_t bytesIn(const fs::path& folder) {
  std::uintmax_t bytes = 0;
  for (const fs::path& file : entries(folder)) bytes += fs::file_size(file);
  return bytes;
}

// The outcome of `work` in a process of its own: 0 where it returned true.
pid_t inProcess(const std::function<bool()>& work) {
  const pid_t child = fork();
  if (child == 0) {
    bool good = false;
    try {
      good = work();
    } catch (...) {
    }
    _exit(good ? 0 : 1);
  }
  return child;
}
bool succeeded(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

TEST(ShapeCache, ASecondRunMakesNothingAndGetsTheSame) {
  const Workplace place;
  Kept first{ShapeCache(place / "c")}, second{ShapeCache(place / "c")};
  const std::uint64_t hash = first.field(ball(0.006));
  EXPECT_EQ(first.made, 2);
  EXPECT_EQ(second.field(ball(0.006)), hash);
  EXPECT_EQ(second.made, 0);
  EXPECT_EQ(entries(place / "c").size(), 2u);
}

TEST(ShapeCache, OtherContentAndSettingsAreOthers) {
  const Workplace place;
  Kept kept{ShapeCache(place / "c")};
  kept.cloud(ball(0.006));
  kept.cloud(ball(0.007));
  kept.cloud(ball(0.006), 0.0011);
  EXPECT_EQ(kept.made, 3);
  Mesh moved = ball(0.006);
  moved.vertices[0].x() = std::nextafter(moved.vertices[0].x(), 1);
  kept.cloud(moved);
  EXPECT_EQ(kept.made, 4);
  const auto make = [&] { return ++kept.made, kept.cloud(moved); };
  kept.cache.cloud(std::vector<NamedMesh>{{"a", moved}}, kVoxel, make);
  kept.cache.cloud(std::vector<NamedMesh>{{"b", moved}}, kVoxel, make);
  EXPECT_EQ(kept.made, 6);
}

TEST(ShapeCache, ABrokenEntryIsMadeAgain) {
  for (const bool cutShort : {false, true}) {
    const Workplace place;
    Kept kept{ShapeCache(place / "c")};
    const std::uint64_t hash = kept.field(ball(0.006));
    for (const fs::path& file : entries(place / "c")) {
      if (cutShort) {
        fs::resize_file(file, fs::file_size(file) / 2);
        continue;
      }
      std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
      const auto middle = static_cast<std::streamoff>(fs::file_size(file) / 2);
      bytes.seekg(middle);
      const auto was = static_cast<char>(bytes.get());
      bytes.seekp(middle);
      bytes.put(static_cast<char>(was ^ 1));
    }
    EXPECT_EQ(kept.field(ball(0.006)), hash);
    EXPECT_EQ(kept.made, 4);
    EXPECT_EQ(kept.field(ball(0.006)), hash);
    EXPECT_EQ(kept.made, 4);
  }
}

TEST(ShapeCache, TheLongestUnusedGoFirst) {
  const Workplace place;
  Kept large{ShapeCache(place / "c")};
  const std::vector<double> radii = {0.006, 0.007, 0.008, 0.009};
  for (const double radius : radii) large.cloud(ball(radius));
  const std::uintmax_t bytes = bytesIn(place / "c");
  // All were used long ago but the first two.
  for (const fs::path& file : entries(place / "c"))
    fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::hours(9));
  large.cloud(ball(0.006));
  large.cloud(ball(0.007));
  Kept small{ShapeCache(place / "c", bytes)};
  small.cloud(ball(0.0065));  // one too many
  EXPECT_LE(bytesIn(place / "c"), bytes);
  small.made = 0;
  small.cloud(ball(0.006));
  small.cloud(ball(0.007));
  small.cloud(ball(0.0065));
  EXPECT_EQ(small.made, 0);
}

TEST(ShapeCache, AFullDiskCostsOnlyTheEntry) {
  const Workplace place;
  EXPECT_TRUE(succeeded(inProcess([&] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{2000, 2000};  // of any file that it writes [bytes]
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0) return false;
    Kept kept{ShapeCache(place / "c")};
    const std::uint64_t hash = kept.field(ball(0.006));
    return kept.field(ball(0.006)) == hash && kept.made >= 3;
  })));
  for (const fs::path& file : entries(place / "c")) EXPECT_LE(fs::file_size(file), 2000u);
  for (const fs::path& file : entries(place / "c")) EXPECT_NE(file.extension(), ".part");
}

TEST(ShapeCache, AFolderThatCannotBeMadeCostsNothingElse) {
  const Workplace place;
  place.write("file", "");
  Kept kept{ShapeCache(place / "file/c")};
  const std::uint64_t hash = kept.field(ball(0.006));
  EXPECT_EQ(kept.field(ball(0.006)), hash);
  EXPECT_EQ(kept.made, 4);
}

// A bound that is always exceeded, so that processes remove what others read.
TEST(ShapeCache, EightProcessesAtOnce) {
  const Workplace place;
  const std::vector<double> radii = {0.005, 0.0055, 0.006};
  std::vector<std::uint64_t> hashes;
  Kept alone{ShapeCache(place / "alone")};
  for (const double radius : radii) hashes.push_back(alone.field(ball(radius)));
  const std::uintmax_t most = bytesIn(place / "alone") / 2;
  std::vector<pid_t> children;
  for (std::size_t n = 0; n < 8; ++n)
    children.push_back(inProcess([&, n] {
      Kept kept{ShapeCache(place / "c", most)};
      for (std::size_t i = 0; i < 12; ++i) {
        const std::size_t k = (i + n) % radii.size();
        if (kept.field(ball(radii[k])) != hashes[k]) return false;
      }
      return true;
    }));
  for (const pid_t child : children) EXPECT_TRUE(succeeded(child));
  for (const fs::path& file : entries(place / "c")) EXPECT_NE(file.extension(), ".part");
}

TEST(ShapeCache, TheEnvironmentSaysWhere) {
  const auto folder = [] {
    const auto cache = usualCache();
    return cache ? cache->folder().string() : "none";
  };
  setenv("XDG_CACHE_HOME", "/x", 1);
  setenv("HOME", "/h", 1);
  unsetenv("CLOUDCONTACT_CACHE");
  EXPECT_EQ(folder(), "/x/cloudcontact");
  setenv("XDG_CACHE_HOME", "relative", 1);  // is ignored, as its specification has it
  EXPECT_EQ(folder(), "/h/.cache/cloudcontact");
  unsetenv("HOME");
  EXPECT_EQ(folder(), "none");
  setenv("CLOUDCONTACT_CACHE", "/given", 1);
  EXPECT_EQ(folder(), "/given");
  setenv("CLOUDCONTACT_CACHE", "off", 1);
  EXPECT_EQ(folder(), "none");
}

TEST(ShapeCache, TheProgramAnswersTheSameFromIt) {
  const Workplace place;
  setenv("CLOUDCONTACT_CACHE", (place / "c").c_str(), 1);
  const std::vector<std::string> words = {
      "contact", "sphere:0.006", "box:0.01,0.01,0.01", "--pose", "0 0.001 0.0105", "--voxel",
      "0.001",   "--json",       "--repeat",           "1"};
  std::vector<std::string> without = words;
  without.push_back("--no-cache");
  auto expected = place.run(without).json();
  EXPECT_FALSE(fs::exists(place / "c"));
  auto first = place.run(words).json();
  EXPECT_EQ(entries(place / "c").size(), 4u);  // two clouds, two fields
  auto second = place.run(words).json();
  for (auto* json : {&expected, &first, &second}) json->erase("microseconds");
  EXPECT_EQ(first, expected);
  EXPECT_EQ(second, expected);
}

}  // namespace

}  // namespace shape_cache_test
