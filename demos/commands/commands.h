// The program's commands: each adds itself to the command line and runs when it is chosen.
// A command throws BadInput or WorkFailed (errors.h); main() turns them into exit codes.
#pragma once

#include "io/errors.h"
#include "io/options.h"

namespace cloudcontact::program {

void addDigitizeCommand(CLI::App& app);
void addContactCommand(CLI::App& app);
void addSimulateCommand(CLI::App& app);
void addDemoCommand(CLI::App& app);
void addChartCommand(CLI::App& app);
void addDrillCommand(CLI::App& app);

}  // namespace cloudcontact::program
