// Adds the options that several commands share.
#include "commands/common_options.h"

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "io/errors.h"
#include "io/solid_text.h"
#include "scene/shape_cache.h"

namespace cloudcontact::program {

namespace {

// Adds an option whose text goes through `reader`.
template <class Reader>
void add(CLI::App& command, const std::string& name, const std::string& help, const char* type,
         Reader reader) {
  command
      .add_option_function<std::string>(
          name, [reader](const std::string& text) { reader(text); }, help)
      ->type_name(type);
}

}  // namespace

void addPositive(CLI::App& command, const std::string& name, const std::string& help,
                 const char* type, const std::function<void(double)>& set) {
  add(command, name, help, type, [name, set](const std::string& t) { set(readPositive(name, t)); });
}

void addFileOptions(CLI::App& command, CommonOptions& o) {
  addPositive(
      command, "--voxel",
      "edge of a voxel [m]; a hundredth of the body's diagonal if not given, down to half of that "
      "for threads and thin walls",
      "H", [&o](double v) { o.voxel = v; });
  add(command, "--unit",
      "unit of mesh, point and volume files that state none: mm, cm, in, m, or its length in "
      "meters (default m)",
      "UNIT", [&o](const std::string& t) { o.metersPerUnit = readUnit(t); });
}

void addBodyOptions(CLI::App& command, CommonOptions& o) {
  addFileOptions(command, o);
  command
      .add_option_function<std::vector<std::string>>(
          "--threshold",
          [&o](const std::vector<std::string>& texts) {
            for (const std::string& t : texts)
              addThreshold("--threshold", readThreshold("--threshold", t), o.thresholds);
          },
          "grey value from which on a CT volume is material; NAME=T, once for each material of "
          "several")
      ->allow_extra_args(false)
      ->type_name("T|NAME=T");
  addPositive(command, "--shell", "thickness given to a sheet [m]; three voxels if not given",
              "THICKNESS", [&o](double v) { o.shell = v; });
}

void addRunOptions(CLI::App& command, CommonOptions& o) {
  add(command, "--threads", "threads to use; 0 means all cores (default)", "N",
      [&o](const std::string& t) { o.threads = readCount("--threads", t, 0, 1024); });
  command.add_flag("--json", o.json, "print the result as JSON");
}

void addCacheOption(CLI::App& command, CommonOptions& o) {
  o.cache = usualCache();
  command.add_flag_callback(
      "--no-cache", [&o] { o.cache.reset(); },
      "neither use nor keep clouds and surfaces of other runs (CLOUDCONTACT_CACHE: their folder, "
      "or "
      "off; ~/.cache/cloudcontact if not given)");
}

void addLawOptions(CLI::App& command, CommonOptions& o) {
  add(command, "--law",
      "contact law: paper (one spring a pair), foundation (stiffness per area); for simulate also "
      "maxwell:K,C (spring and dashpot in series), solid:K,K1,C1 (a spring beside such a pair)",
      "LAW", [&o](const std::string& t) { o.law = readLaw(t); });
  addPositive(command, "--stiffness", "the pair's k [N/m]; per area [N/m^3] with foundation", "K",
              [&o](double v) { o.stiffness = v; });
  add(command, "--damping", "the pair's c [N s/m]; per area [N s/m^3] with foundation", "C",
      [&o](const std::string& t) { o.damping = readNotNegative("--damping", t); });
}

void addFrictionOption(CLI::App& command, CommonOptions& o) {
  add(command, "--friction", "the pair's friction coefficient", "MU",
      [&o](const std::string& t) { o.friction = readNotNegative("--friction", t); });
}

void addMethodOption(CLI::App& command, CommonOptions& o) {
  add(command, "--method",
      "cloud (base vectors, default), paper (the same, with what is stated), or Bullet's gjk, "
      "gimpact, hacd, primitive, sdf",
      "cloud|paper|gjk|gimpact|hacd|primitive|sdf",
      [&o](const std::string& t) { o.method = readMethod(t); });
}

void addSamplesOption(CLI::App& command, CommonOptions& o) {
  add(command, "--samples",
      "hits that a search looks for; fewer are faster and less accurate (default 300)", "N",
      [&o](const std::string& t) { o.samples = readCount("--samples", t, 1, 1000000000); });
}

void addToleranceOption(CLI::App& command, CommonOptions& o) {
  add(command, "--tolerance",
      "contacts take the largest voxels whose surface is right to this [m], and a cloud that is a "
      "ball, box, cylinder, capsule, cone or convex body with flat faces within it meets others as "
      "that shape; if not given, one that is it as far as its voxels tell does; 'exact': none does",
      "T|exact", [&o](const std::string& text) {
        o.exact = text == "exact";
        o.tolerance = o.exact ? 0 : readPositive("--tolerance", text);
      });
  addPositive(
      command, "--budget",
      "with --tolerance: the least important contacts get coarser where a step's would take longer "
      "than this [s], as counted",
      "S", [&o](double v) { o.budget = v; });
}

void addPaperOptions(CLI::App& command, CommonOptions& o) {
  add(command, "--window",
      "the paper's C around each voxel [m]: sphere:R, box:X,Y,Z or ellipsoid:X,Y,Z, full lengths; "
      "a sphere of 2.5 voxels if not given",
      "SOLID", [&o](const std::string& t) { o.paper.window = readWindow("--window", t); });
  add(command, "--representative", "the paper's Gr, from the center of C [m] (default \"0 0 0\")",
      "\"x y z\"",
      [&o](const std::string& t) { o.paper.representative = readVector("--representative", t); });
  add(command, "--membership",
      "which voxels are in D: by their share in it (shared, if not given) or by their centers, the "
      "paper's (whole)",
      "whole|shared", [&o](const std::string& t) {
        if (t != "whole" && t != "shared")
          throw BadInput("--membership: " + t + " is not known; give whole or shared");
        o.paper.membership = t == "whole" ? Membership::Whole : Membership::Shared;
      });
  command.add_flag("--hardness", o.paper.hardness,
                   "base vectors count by the hardness of their tissue, (5') of the paper");
}

void addTissueOptions(CLI::App& command, CommonOptions& o, const char* none) {
  command
      .add_option("--tissues", o.tissues.table,
                  std::string("table of tissues, with k and c of each; ") + none)
      ->type_name("dental|FILE.json");
  command
      .add_option_function<std::vector<std::string>>(
          "--tissue",
          [&o](const std::vector<std::string>& texts) {
            for (const std::string& t : texts) {
              const auto part = readTissueName("--tissue", t);
              for (const auto& [known, tissue] : o.tissues.ofParts)
                if (known == part.first)
                  throw BadInput("--tissue: part " + known + " is given twice; leave one out");
              o.tissues.ofParts.push_back(part);
            }
          },
          "the tissue of a part, once for each part; 'all' for a body of one part")
      ->allow_extra_args(false)
      ->type_name("PART=TISSUE");
}

void addBackendOption(CLI::App& command, CommonOptions& o) {
  add(command, "--backend", "cpu, or opencl for a GPU", "cpu|opencl",
      [&o](const std::string& t) { o.backend = readBackend(t); });
}

}  // namespace cloudcontact::program
