// What every main() of the program does: it parses, runs, and turns failures into exit codes.
#pragma once

#include <CLI/CLI.hpp>

namespace cloudcontact::program {

// Lets `add` give `app` its commands or options, then parses and runs them. A failure becomes one
// line on stderr and an exit code: 0 done, 1 the work failed, 2 bad input. Throws nothing.
int runCommandLine(int argc, char** argv, CLI::App& app, void (*add)(CLI::App&)) noexcept;

}  // namespace cloudcontact::program
