// The options that several commands share, as the command line has them (io/options.h: their
// values).
#pragma once

#include "io/options.h"

namespace CLI {
class App;
}

namespace cloudcontact::program {

// Whether a command can use an OpenCL device.
enum class Devices { None, OpenCl };

// Adds the options to a command. They fill `options`, which must live until the command has run. An
// invalid value throws BadInput naming the option and its valid values. A command that cannot use a
// device runs on the CPU and says so on stderr.
void addCommonOptions(CLI::App& command, CommonOptions& options, Devices devices = Devices::None);

}  // namespace cloudcontact::program
