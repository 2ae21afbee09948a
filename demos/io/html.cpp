// Text only: attributes are never made of what files say.
#include "io/html.h"

namespace cloudcontact::program {

std::string asHtml(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '&')
      out += "&amp;";
    else
      out += c;
  }
  return out;
}

}  // namespace cloudcontact::program
