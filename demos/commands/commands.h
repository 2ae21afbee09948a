// The program's commands. Each function adds one to the command line. Commands throw BadInput or
// WorkFailed (io/errors.h), which main() turns into exit codes.
#pragma once

#include <functional>
#include <string>

#include "commands/common_options.h"
#include "io/errors.h"
#include "scene/scene.h"

namespace cloudcontact::program {

void addDigitizeCommand(CLI::App& app);
void addContactCommand(CLI::App& app);
void addSimulateCommand(CLI::App& app);
// `readRobot`: robotOf() of scene_file.h, in a program that reads scene files.
using RobotReader =
    std::function<SceneDescription(const std::string& name, const std::string& text)>;
void addDemoCommand(CLI::App& app, RobotReader readRobot = {});
void addChartCommand(CLI::App& app);
void addDrillCommand(CLI::App& app);
void addTuneCommand(CLI::App& app);
void addCompletionCommand(CLI::App& app);
void addManualCommand(CLI::App& app);

}  // namespace cloudcontact::program
