// The program's commands. Each function adds one to the command line. Commands throw BadInput or
// WorkFailed (io/errors.h), which main() turns into exit codes.
#pragma once

#include "commands/common_options.h"
#include "io/errors.h"

namespace cloudcontact::program {

void addDigitizeCommand(CLI::App& app);
void addContactCommand(CLI::App& app);
void addSimulateCommand(CLI::App& app);
void addDemoCommand(CLI::App& app);
void addChartCommand(CLI::App& app);
void addDrillCommand(CLI::App& app);
void addTuneCommand(CLI::App& app);
void addCompletionCommand(CLI::App& app);
void addManualCommand(CLI::App& app);

}  // namespace cloudcontact::program
