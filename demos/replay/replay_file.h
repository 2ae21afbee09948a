// `--replay FILE`: a replay kept as glTF or as a page, whichever the file's name asks for.
#pragma once

#include <string>

#include "replay/replay.h"

namespace cloudcontact::program {

// Throws BadInput naming --replay where `file` ends in neither .glb nor .html or cannot be written:
// before the work rather than after it.
void checkReplay(const std::string& file);

// Writes the file whole or not at all. Throws BadInput or WorkFailed naming it.
void saveReplay(const Replay& replay, const std::string& file);

}  // namespace cloudcontact::program
