// Text that goes into HTML.
#pragma once

#include <string>

namespace cloudcontact::program {

// What would be read as a tag or an entity is shown as it is.
std::string asHtml(const std::string& text);

}  // namespace cloudcontact::program
