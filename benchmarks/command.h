// The main function of a benchmark with options: reads them, runs it, and says what went wrong.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdio>
#include <stdexcept>

namespace cloudcontact {

// Returns the exit status: CLI11's for --help and wrong options, 1 if the work throws.
template <typename Work>
int runCommand(CLI::App& words, int argc, char** argv, Work&& work) {
  try {
    words.parse(argc, argv);
    work();
    return 0;
  } catch (const CLI::Error& wrong) {
    return words.exit(wrong);
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "%s: %s\n", words.get_name().c_str(), failure.what());
    return 1;
  }
}

}  // namespace cloudcontact
