// Which target the fuzz program runs.
#pragma once

#include "fuzz/fuzz_target.h"

namespace cloudcontact::fuzz {

// By the argument --target=NAME. Writes seeds or lists targets, and ends the program, where the
// arguments say so. Ends it with 2 where they make no sense.
Target chosenTarget(int argc, char** argv);

// What follows `--name=` among the arguments; empty where it is not there.
std::string argumentOf(const std::string& name, int argc, char** argv);

}  // namespace cloudcontact::fuzz
