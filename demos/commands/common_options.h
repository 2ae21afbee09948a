// The options that several commands share, as the command line has them (io/options.h: their
// values). A command adds those that it uses; others are refused as unknown.
#pragma once

#include "io/options.h"

#include <functional>
#include <string>

namespace CLI {
class App;
}

namespace cloudcontact::program {

// An option that takes a positive number and hands it to `set`.
void addPositive(CLI::App& command, const std::string& name, const std::string& help,
                 const char* type, const std::function<void(double)>& set);

// Each adds options to a command. They fill `options`, which must live until the command has run.
// An invalid value throws BadInput naming the option and its valid values.

void addFileOptions(CLI::App& command, CommonOptions& options);  // --voxel, --unit
void addBodyOptions(CLI::App& command, CommonOptions& options);  // those, --threshold and --shell
void addRunOptions(CLI::App& command, CommonOptions& options);   // --threads, --json
void addCacheOption(CLI::App& command, CommonOptions& options);  // --no-cache; else the user's
void addLawOptions(CLI::App& command, CommonOptions& options);   // --law, --stiffness, --damping
void addFrictionOption(CLI::App& command, CommonOptions& options);
void addMethodOption(CLI::App& command, CommonOptions& options);
void addSamplesOption(CLI::App& command, CommonOptions& options);
void addToleranceOption(CLI::App& command, CommonOptions& options);
// --window, --representative, --hardness
void addPaperOptions(CLI::App& command, CommonOptions& options);
// --tissues and --tissue; `none`: what holds without them.
void addTissueOptions(CLI::App& command, CommonOptions& options, const char* none);
// Without a device the command runs on the CPU and says so on stderr.
void addBackendOption(CLI::App& command, CommonOptions& options);

}  // namespace cloudcontact::program
