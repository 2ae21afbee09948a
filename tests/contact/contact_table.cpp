// contact_table: prints the errors of every contact case. For developers; not a test.
//
//   contact_table [part-of-a-name ...] [--depths 0.3,0.6,1] [--instances 12] [--seed 1]
//                 [--voxel 1e-3] [--law paper|foundation]
//
// With the single part `field` it prints the errors of fields instead: depth (bias, mean, worst)
// and normal (mean, worst) away from edges and within 3 voxels of them, then errors of side
// (inside, outside), then the samples' area, volume, distance from the surface, and strips beside
// edges (field_cases.h).
//
// Lengths in voxels, mean/largest over the instances; +- columns are signed means. A mark (!)
// behind a number: beyond the bound of the tests.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <sstream>
#include <stdexcept>

#include "field/field_cases.h"

namespace cc = cloudcontact;
namespace ct = cloudcontact::testing;

namespace {

struct Options {
  std::vector<std::string> parts;
  std::vector<double> depths{0.3, 0.6, 1.0};
  ct::RunSettings run;
};

std::vector<double> numbers(const std::string& list) {
  std::vector<double> found;
  std::stringstream stream(list);
  for (std::string item; std::getline(stream, item, ',');) found.push_back(std::stod(item));
  return found;
}

Options parsed(int argc, char** argv) {
  Options options;
  for (int k = 1; k < argc; ++k) {
    const std::string key = argv[k];
    if (key.rfind("--", 0) != 0) {
      options.parts.push_back(key);
      continue;
    }
    if (++k >= argc) throw std::invalid_argument(key + ": needs a value");
    const std::string value = argv[k];
    if (key == "--depths")
      options.depths = numbers(value);
    else if (key == "--instances")
      options.run.instances = std::stoi(value);
    else if (key == "--seed")
      options.run.seed = std::stoull(value);
    else if (key == "--voxel")
      options.run.voxel = std::stod(value);
    else if (key == "--law" && value == "paper")
      options.run.contact.law = cc::KelvinVoigt{1e4, 0};
    else if (key == "--law" && value == "foundation")
      options.run.contact.law = cc::Foundation{1e4, 0};
    else
      throw std::invalid_argument(key + " " + value + ": see the first lines of contact_table.cpp");
  }
  return options;
}

bool wanted(const Options& options, const std::string& name) {
  if (options.parts.empty()) return true;
  for (const std::string& part : options.parts) {
    if (name.find(part) != std::string::npos) return true;
  }
  return false;
}

void fieldRow(const char* where, const ct::FieldErrors& e) {
  std::printf("  %-6s depth %+.4f %.4f %.3f  normal %7.3f %7.2f  (%d points, %d missing)\n", where,
              e.depthBias, e.depthMean, e.depthWorst, e.normalMean, e.normalWorst, e.points,
              e.missing);
}

void fieldTable(const Options& options) {
  const int clouds = std::min(options.run.instances, 4);
  ct::BodyMaker maker{options.run.voxel, ct::Random(options.run.seed), options.run.field};
  for (const ct::SolidCase& one : ct::solidCases()) {
    std::printf("%s\n", one.name.c_str());
    fieldRow("smooth", ct::fieldErrors(one, 4, 1e10, 1, clouds, maker));
    if (one.name.find("sphere") != 0) {
      fieldRow("edges", ct::fieldErrors(one, 0, 3, 0, clouds, maker));
    }
    const ct::FieldSides sides = ct::fieldSides(one, clouds, maker);
    std::printf("  sides  false overlap %+.3f (%d of %d points)  false gap %+.3f (%d of %d)\n",
                sides.falseOverlap, sides.falseOutside, sides.outside, sides.falseGap,
                sides.falseInside, sides.inside);
    for (int k = 0; k < clouds; ++k) {
      const ct::SampleSums s = ct::sampleSums(one, one.make(maker));
      std::printf("  samples area %+.2f%% volume %+.2f%% off %.4f %.3f normal %.3f closed %.5f",
                  100 * (s.area / one.area - 1), 100 * (s.volume / one.volume - 1), s.offMean,
                  s.offWorst, s.normalMean, s.vectorArea.norm() / one.area);
      if (one.box) {
        std::printf("  strips .5 %+.1f%% (%+.0f%%) 1 %+.1f%% (%+.0f%%)", 100 * s.stripMean[0],
                    100 * s.stripWorst[0], 100 * s.stripMean[1], 100 * s.stripWorst[1]);
      }
      std::printf("\n");
    }
    std::fflush(stdout);
  }
}

void pair(double mean, double worst, double bound, int digits) {
  std::printf(" %8.*f/%-8.*f%c", digits, mean, digits, worst, worst > bound ? '!' : ' ');
}

void row(const std::string& name, double depth, const ct::ErrorSummary& s, const ct::Bounds& b) {
  std::printf("%-24s %4.2f", name.c_str(), depth);
  pair(s.mean.normalDeg, s.worst.normalDeg, b.normalDeg, 3);
  pair(s.mean.depth, s.worst.depth, b.depth, 4);
  std::printf(" %+7.4f", s.depthBias);
  pair(s.mean.center, s.worst.center, b.center, 3);
  pair(100 * s.mean.forceRelative, 100 * s.worst.forceRelative, 100 * b.forceRelative, 2);
  std::printf(" %+6.2f %6.3f %3zu/%-3zu %3zu/%-3zu %6zu %d\n", 100 * s.forceBias, s.worst.spin,
              s.mean.patches, s.worst.patches, s.mean.points, s.worst.points, s.mean.samples,
              s.missed);
}

void table(const Options& options) {
  std::printf("%-24s %4s %-19s %-19s %7s %-19s %-19s %6s %6s %-7s %-7s %6s %s\n", "case", "d",
              "      normal deg", "      depth", "+-", "      center", "      force %", "+-",
              "spin", "patches", "points", "sample", "missed");
  for (const ct::ContactCase& one : ct::contactCases()) {
    if (!wanted(options, one.name)) continue;
    const auto summaries = ct::runCase(one, options.depths, options.run);
    for (std::size_t k = 0; k < options.depths.size(); ++k) {
      row(one.name, options.depths[k], summaries[k], one.bounds);
    }
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Options options = parsed(argc, argv);
    if (options.parts == std::vector<std::string>{"field"})
      fieldTable(options);
    else
      table(options);
  } catch (const std::exception& error) {
    std::cerr << "contact_table: " << error.what() << '\n';
    return 2;
  }
  return 0;
}
