// `--replay FILE`: saves a replay as glTF or as a page, by the file's extension.
#pragma once

#include <string>

#include "replay/replay.h"

namespace cloudcontact::program {

// Throws BadInput naming --replay if `file` ends in neither .glb nor .html or cannot be written.
// Call it before the work starts.
void checkReplay(const std::string& file);

// Writes the file whole or not at all. Throws BadInput or WorkFailed naming it.
void saveReplay(const Replay& replay, const std::string& file);

}  // namespace cloudcontact::program
