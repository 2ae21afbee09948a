// Prints what is embedded in it: a text with all kinds of marks, and this file.
#include <cstdio>
#include <string_view>

namespace cloudcontact::program::embedded {
std::string_view marks();
}

int main() {
  const std::string_view text = cloudcontact::program::embedded::marks();
  return std::fwrite(text.data(), 1, text.size(), stdout) == text.size() ? 0 : 1;
}
