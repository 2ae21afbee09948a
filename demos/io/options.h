// The options that several commands share, and strict readers for what users type.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/device/contact_batch.h>
#include <cloudcontact/law/law.h>

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace cloudcontact::program {

enum class Method { Cloud, Gjk, Gimpact, Hacd, Primitive, Sdf };

std::string_view nameOf(Method method);
std::string_view nameOf(Backend backend);

// What the common options say. Empty: not given on the command line; the command decides.
struct CommonOptions {
  std::optional<double> voxel;  // [m]
  double metresPerUnit = 1;     // of mesh files: --unit
  std::optional<double> shell;  // thickness of a sheet [m]; three voxels where empty
  // --law: paper|foundation|rigid (without k and c) or maxwell:K,C or solid:K,K1,C1
  Law law = KelvinVoigt{};
  std::optional<double> stiffness;  // the pair's k: [N/m], [N/m^3] with foundation
  std::optional<double> damping;    // the pair's c: [N s/m], [N s/m^3] with foundation
  std::optional<double> friction;   // the pair's coefficient
  Method method = Method::Cloud;
  Backend backend = Backend::Cpu;
  int threads = 0;  // 0: all cores
  bool json = false;
};

// Whether --law names a law with its own values and a memory.
bool isViscoelastic(const Law& law);

// Whether a command has something to do on an OpenCL device.
enum class Devices { None, OpenCl };

// Adds the options to a command; they fill `options`, which must live until the command has run.
// Values are checked as they are read: BadInput names the option and what it takes. A command
// without use for a device takes the CPU, and says so.
void addCommonOptions(CLI::App& command, CommonOptions& options, Devices devices = Devices::None);

// Says on stderr why the CPU does what --backend opencl was to do.
void tellOfCpu(const std::string& why);

// The readers. `option` is the name users know the value by, and starts the message of BadInput.
double readNumber(std::string_view option, const std::string& text);    // finite
double readPositive(std::string_view option, const std::string& text);  // finite, > 0
double readNotNegative(std::string_view option, const std::string& text);
int readCount(std::string_view option, const std::string& text, int least, int most);
// "x y z" or "x y z qx qy qz qw"; the quaternion is normalised.
Pose readPose(std::string_view option, const std::string& text);
// "vx vy vz wx wy wz"
Motion readVelocity(std::string_view option, const std::string& text);

}  // namespace cloudcontact::program
