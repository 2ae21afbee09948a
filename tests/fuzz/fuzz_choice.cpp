// Chooses the target of the fuzz program by its arguments.
#include "fuzz/fuzz_choice.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace cloudcontact::fuzz {

std::vector<Target> allTargets() {
  return {arraysTarget(), cacheTarget(),   cloudTarget(),   fieldTarget(),
          meshTarget(),   optionsTarget(), pairTarget(),    pointsTarget(),
          recordTarget(), sceneTarget(),   tissuesTarget(), volumeTarget()};
}

std::string argumentOf(const std::string& name, int argc, char** argv) {
  const std::string start = "--" + name + "=";
  for (int i = 1; i < argc; ++i)
    if (const std::string word = argv[i]; word.starts_with(start)) return word.substr(start.size());
  return {};
}

namespace {

[[noreturn]] void writeSeeds(const Target& target, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  int number = 0;
  for (const std::string& seed : target.seeds()) {
    std::ofstream out(folder / ("seed-" + std::to_string(number++)), std::ios::binary);
    out.write(seed.data(), static_cast<std::streamsize>(seed.size()));
    out.close();
    require(bool(out), "seeds cannot be written to " + folder.string());
  }
  std::exit(0);
}

}  // namespace

Target chosenTarget(int argc, char** argv) {
  const std::string name = argumentOf("target", argc, argv);
  for (const Target& target : allTargets()) {
    if (argc > 1 && argv[1] == std::string("--list")) std::puts(target.name);
    if (target.name != name) continue;
    const std::string folder = argumentOf("seeds", argc, argv);
    if (!folder.empty()) writeSeeds(target, folder);
    return target;
  }
  if (argc > 1 && argv[1] == std::string("--list")) std::exit(0);
  std::fprintf(stderr, "cloudcontact_fuzz: '%s' is no target; --list names them\n", name.c_str());
  std::exit(2);
}

}  // namespace cloudcontact::fuzz
