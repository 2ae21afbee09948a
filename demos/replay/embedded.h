// The files of the replay page, and of demos, embedded into the program by cmake/EmbedText.cmake.
#pragma once

#include <string_view>

namespace cloudcontact::program::embedded {

std::string_view page_html();
std::string_view page_css();
std::string_view page_js();
std::string_view three_js();
std::string_view orbit_js();
std::string_view gltf_js();
std::string_view arm_urdf();

}  // namespace cloudcontact::program::embedded
