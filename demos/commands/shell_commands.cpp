// `cloudcontact completion` and `cloudcontact manual`: what shells and `man` know of the program,
// from its own commands.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <string>

#include "commands/command_tree.h"
#include "commands/commands.h"
#include "commands/completion_text.h"
#include "commands/manual_text.h"

namespace cloudcontact::program {

void addCompletionCommand(CLI::App& app) {
  auto shell = std::make_shared<std::string>();
  CLI::App& command =
      *app.add_subcommand("completion",
                          "print the completion script of a shell.\n"
                          "`cmake --install` installs those of bash, zsh and fish.");
  command.add_option("bash|zsh|fish", *shell, "the shell")->required();
  addExamples(command, {"cloudcontact completion bash > cloudcontact.bash",
                        "cloudcontact completion zsh > _cloudcontact",
                        "cloudcontact completion fish > cloudcontact.fish"});
  command.callback([shell, &app] {
    const CommandText program = commandText(app);
    const std::vector<CommandText> commands = commandTexts(app);
    if (*shell == "bash")
      std::cout << bashCompletion(program, commands);
    else if (*shell == "zsh")
      std::cout << zshCompletion(program, commands);
    else if (*shell == "fish")
      std::cout << fishCompletion(program, commands);
    else
      throw BadInput("completion: '" + *shell + "' is no shell known here; give bash, zsh or fish");
  });
}

void addManualCommand(CLI::App& app) {
  CLI::App& command =
      *app.add_subcommand("manual", "print the manual page in roff, which `man` shows.");
  addExamples(command, {"cloudcontact manual > cloudcontact.1", "man ./cloudcontact.1"});
  command.callback([&app] { std::cout << manualPage(commandText(app), commandTexts(app)); });
}

}  // namespace cloudcontact::program
