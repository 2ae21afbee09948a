// The files that a scene's URIs mean.
#pragma once

#include <filesystem>
#include <string>

namespace cloudcontact::program {

// Of a scene in `folder`. file://PATH is PATH. Robots call their packages by name:
// package://NAME/FILE, which libsdformat turns into model://, is FILE in the folder NAME that is,
// or is in, one of the folders above. Others, and those that are not found, are returned as they
// are.
std::string pathOf(const std::string& uri, const std::filesystem::path& folder);

}  // namespace cloudcontact::program
