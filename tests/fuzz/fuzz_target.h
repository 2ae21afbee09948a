// A fuzz target: a reader of input that nobody has checked, and seeds from which a fuzzer makes
// such input. The program cloudcontact_fuzz runs one of them, under libFuzzer (script/fuzz) or a
// few thousand times with fixed mutations (the tests).
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cloudcontact::fuzz {

struct Target {
  const char* name;
  // Ends the program where the reader does what it must not: a wrong result, an error that does not
  // name the input.
  void (*run)(std::string_view input);
  // Valid inputs. Made by code, so that no binary files are kept.
  std::vector<std::string> (*seeds)();
  std::size_t longest;  // bytes of an input
};

Target arraysTarget();
Target cacheTarget();
Target cloudTarget();
Target fieldTarget();
Target meshTarget();
Target optionsTarget();
Target pairTarget();
Target pointsTarget();
Target recordTarget();
Target sceneTarget();
Target tissuesTarget();
Target volumeTarget();

std::vector<Target> allTargets();

// Prints and ends the program unless `holds`.
void require(bool holds, const std::string& what);

}  // namespace cloudcontact::fuzz
