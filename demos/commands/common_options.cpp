// Adds the options that several commands share.
#include "commands/common_options.h"

#include <CLI/CLI.hpp>
#include <string>

#include "io/errors.h"

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

void addLawOptions(CLI::App& command, CommonOptions& o) {
  add(command, "--law",
      "contact law: paper (one spring a pair), foundation (stiffness per area); for simulate also "
      "maxwell:K,C (spring and dashpot in series), solid:K,K1,C1 (a spring beside such a pair)",
      "LAW", [&o](const std::string& t) { o.law = readLaw(t); });
  add(command, "--stiffness", "the pair's k [N/m]; per area [N/m^3] with foundation", "K",
      [&o](const std::string& t) { o.stiffness = readPositive("--stiffness", t); });
  add(command, "--damping", "the pair's c [N s/m]; per area [N s/m^3] with foundation", "C",
      [&o](const std::string& t) { o.damping = readNotNegative("--damping", t); });
  add(command, "--friction", "the pair's friction coefficient", "MU",
      [&o](const std::string& t) { o.friction = readNotNegative("--friction", t); });
  add(command, "--material", "a material's name or file (not supported yet)", "NAME|FILE",
      [](const std::string& t) {
        throw BadInput("--material: '" + t +
                       "' cannot be looked up, materials tables are not supported yet; give "
                       "--stiffness and --damping instead");
      });
}

}  // namespace

void addCommonOptions(CLI::App& command, CommonOptions& o, Devices devices) {
  add(command, "--voxel", "edge of a voxel [m]; a hundredth of the body's diagonal if not given",
      "H", [&o](const std::string& t) { o.voxel = readPositive("--voxel", t); });
  add(command, "--unit", "unit of mesh files: mm, cm, in, m, or its length in meters (default m)",
      "UNIT", [&o](const std::string& t) { o.metersPerUnit = readUnit(t); });
  add(command, "--shell", "thickness given to a sheet [m]; three voxels if not given", "THICKNESS",
      [&o](const std::string& t) { o.shell = readPositive("--shell", t); });
  addLawOptions(command, o);
  add(command, "--method", "cloud, or Bullet's gjk, gimpact, hacd, primitive, sdf", "METHOD",
      [&o](const std::string& t) { o.method = readMethod(t); });
  const bool none = devices == Devices::None;
  add(command, "--backend", none ? "cpu" : "cpu, or opencl for a GPU", "BACKEND",
      [&o, none, name = command.get_name()](const std::string& t) {
        o.backend = readBackend(t);
        if (o.backend != Backend::OpenCl || !none) return;
        reportCpuFallback(name + " cannot use a device");
        o.backend = Backend::Cpu;
      });
  add(command, "--threads", "threads to use; 0 means all cores (default)", "N",
      [&o](const std::string& t) { o.threads = readCount("--threads", t, 0, 1024); });
  command.add_flag("--json", o.json, "print the result as JSON");
}

}  // namespace cloudcontact::program
