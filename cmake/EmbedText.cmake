# cloudcontact_embed(TARGET NAME FILE...): adds the function cloudcontact::program::embedded::NAME() to the target,
# which returns the files, one after the other. It is rebuilt when one of them changes. Where the assembler knows
# .incbin it includes the files; otherwise, or with CLOUDCONTACT_INCBIN=OFF, EmbedBytes.cmake writes them as an array,
# which takes the compiler seconds.
include(CheckSourceCompiles)
if(NOT DEFINED CLOUDCONTACT_INCBIN)
  set(CMAKE_REQUIRED_QUIET ON)
  check_source_compiles(CXX [[
    __asm__(".section .rodata\ncloudcontact_begin:\n.incbin \"/dev/null\"\n.ascii \"\\n\"\n.previous\n");
    extern "C" const char begin[] __asm__("cloudcontact_begin");
    int main() { return begin[0] == 0; }]] CLOUDCONTACT_INCBIN)
  unset(CMAKE_REQUIRED_QUIET)
endif()
set(CLOUDCONTACT_EMBED_BYTES ${CMAKE_CURRENT_LIST_DIR}/EmbedBytes.cmake)

function(cloudcontact_embed target name)
  list(TRANSFORM ARGN REPLACE "^([^/].*)" "${CMAKE_CURRENT_SOURCE_DIR}/\\1" OUTPUT_VARIABLE paths)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/embedded_${name}.cpp)
  if(CLOUDCONTACT_INCBIN)
    cloudcontact_embed_by_assembler()
    # A unity build would forget what the object depends on.
    set_source_files_properties(${source} PROPERTIES OBJECT_DEPENDS "${paths}" SKIP_UNITY_BUILD_INCLUSION ON)
  else()
    add_custom_command(OUTPUT ${source} DEPENDS ${paths} ${CLOUDCONTACT_EMBED_BYTES} VERBATIM
      COMMAND ${CMAKE_COMMAND} -DOUTPUT=${source} -DNAME=${name} "-DSOURCES=${paths}" -P ${CLOUDCONTACT_EMBED_BYTES})
  endif()
  target_sources(${target} PRIVATE ${source})
endfunction()

macro(cloudcontact_embed_by_assembler)
  set(includes "")
  foreach(path ${paths})
    string(APPEND includes "    \".incbin \\\"${path}\\\"\\n\"\n    \".ascii \\\"\\\\n\\\"\\n\"\n")
  endforeach()
  set(symbol cloudcontact_embedded_${name})
  file(CONFIGURE OUTPUT ${source} @ONLY CONTENT [[// Made by EmbedText.cmake.
#include <cstddef>
#include <string_view>

__asm__(
    ".section .rodata\n"
    "@symbol@_begin:\n"
@includes@
    "@symbol@_end:\n"
    ".previous\n");
extern "C" const char begin_@name@[] __asm__("@symbol@_begin");
extern "C" const char end_@name@[] __asm__("@symbol@_end");

namespace cloudcontact::program::embedded {
std::string_view @name@();
std::string_view @name@() {
  return {begin_@name@, static_cast<std::size_t>(end_@name@ - begin_@name@)};
}
}
]])
endmacro()
