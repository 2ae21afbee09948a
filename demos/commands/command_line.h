// Parses a command line, runs it and turns failures into exit codes, for main().
#pragma once

namespace CLI {
class App;
}

namespace cloudcontact::program {

// Calls `add` to add the commands or options to `app`, then parses and runs. A failure becomes one
// line on stderr. Returns the exit code: 0 done, 1 the work failed, 2 bad input.
int runCommandLine(int argc, char** argv, CLI::App& app, void (*add)(CLI::App&)) noexcept;

}  // namespace cloudcontact::program
