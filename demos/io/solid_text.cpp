// Reads the names and sizes of solids.
#include "io/solid_text.h"

#include <sstream>
#include <vector>

#include "io/errors.h"
#include "io/options.h"

namespace cloudcontact::program {

namespace {

// Lengths whose squares fit single precision, in which Bullet may run. [m]
constexpr double kLeastLength = 1e-7, kGreatestLength = 1e6;

struct SolidKind {
  const char* name;
  std::size_t numbers;
  const char* form;
  Solid (*make)(const std::vector<double>&);
  bool isBody, isWindow;
};

constexpr SolidKind kSolidKinds[] = {
    {"sphere", 1, "sphere:RADIUS",
     [](const std::vector<double>& v) -> Solid { return Sphere{v[0]}; }, true, true},
    {"box", 3, "box:X,Y,Z (full edges)",
     [](const std::vector<double>& v) -> Solid { return Box{Vec3(v[0], v[1], v[2]) / 2}; }, true,
     true},
    {"cylinder", 2, "cylinder:RADIUS,HEIGHT",
     [](const std::vector<double>& v) -> Solid {
       return Cylinder{v[0], v[1] / 2};
     },
     true, false},
    {"capsule", 2, "capsule:RADIUS,HEIGHT (between the caps' centers)",
     [](const std::vector<double>& v) -> Solid {
       return Capsule{v[0], v[1] / 2};
     },
     true, false},
    {"cone", 2, "cone:RADIUS,HEIGHT",
     [](const std::vector<double>& v) -> Solid {
       return Cone{v[0], v[1] / 2};
     },
     true, false},
    {"ellipsoid", 3, "ellipsoid:X,Y,Z (full lengths of its axes)",
     [](const std::vector<double>& v) -> Solid { return Ellipsoid{Vec3(v[0], v[1], v[2]) / 2}; },
     false, true},
};

// `where` starts messages: the text itself, or an option and the text.
Solid readSizes(const std::string& where, const SolidKind& kind, const std::string& list) {
  std::vector<double> sizes;
  std::istringstream words(list);
  for (std::string word; std::getline(words, word, ',');) {
    const double size = readPositive(where, word);
    if (size < kLeastLength || size > kGreatestLength)
      throw BadInput(where + ": " + word + " m is out of range; sizes are from 1e-7 m to 1e6 m");
    sizes.push_back(size);
  }
  if (sizes.size() != kind.numbers || list.back() == ',')
    throw BadInput(where + ": wrong number of sizes; write " + kind.form + ", in meters");
  return kind.make(sizes);
}

std::optional<Solid> readSolid(const std::string& where, const std::string& text,
                               bool SolidKind::*use) {
  const std::size_t colon = text.find(':');
  const std::string name = text.substr(0, colon);
  for (const SolidKind& kind : kSolidKinds) {
    if (name != kind.name || !(kind.*use)) continue;
    if (colon == std::string::npos || colon + 1 == text.size())
      throw BadInput(where + ": sizes are missing; write " + kind.form + ", in meters");
    return readSizes(where, kind, text.substr(colon + 1));
  }
  return {};
}

}  // namespace

std::optional<Solid> readPrimitive(const std::string& text) {
  if (text == "halfspace") return HalfSpace{};
  return readSolid(text, text, &SolidKind::isBody);
}

Solid readWindow(const std::string& option, const std::string& text) {
  if (const auto solid = readSolid(option + ": " + text, text, &SolidKind::isWindow)) return *solid;
  throw BadInput(option + ": '" + text +
                 "' is no window; give sphere:R, box:X,Y,Z or ellipsoid:X,Y,Z, in meters");
}

}  // namespace cloudcontact::program
