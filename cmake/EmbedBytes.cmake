# Writes files as one array of bytes, for EmbedText.cmake:
# cmake -DOUTPUT=FILE -DNAME=name -DSOURCES="a.js;b.js" -P EmbedBytes.cmake
set(bytes "")
foreach(source ${SOURCES})
  file(READ ${source} part HEX)
  string(APPEND bytes "${part}0a")
endforeach()
string(REGEX REPLACE "(................................)" "\\1\n" bytes "${bytes}")
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
file(WRITE ${OUTPUT} "// Made by EmbedBytes.cmake.
#include <string_view>

namespace {
constexpr unsigned char kBytes_${NAME}[] = {
${bytes}};
}

namespace cloudcontact::program::embedded {
std::string_view ${NAME}();
std::string_view ${NAME}() { return {reinterpret_cast<const char*>(kBytes_${NAME}), sizeof kBytes_${NAME}}; }
}
")
