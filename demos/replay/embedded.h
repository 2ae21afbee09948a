// Files that are part of the program, as they were when it was built (embed.cmake).
#pragma once

#include <string_view>

namespace cloudcontact::program::embedded {

std::string_view page_html();
std::string_view page_css();
std::string_view page_js();
std::string_view three_js();
std::string_view orbit_js();
std::string_view gltf_js();
std::string_view plots_py();  // of the laboratory

}  // namespace cloudcontact::program::embedded
