# cloudcontact_embed(TARGET NAME FILE...): adds the function cloudcontact::program::embedded::NAME() to the target,
# which returns the files, one after the other. It is rebuilt when one of them changes.
function(cloudcontact_embed target name)
  set(includes "")
  foreach(file ${ARGN})
    get_filename_component(path ${file} ABSOLUTE)
    string(APPEND includes "    \".incbin \\\"${path}\\\"\\n\"\n    \".ascii \\\"\\\\n\\\"\\n\"\n")
    list(APPEND paths ${path})
  endforeach()
  set(source ${CMAKE_CURRENT_BINARY_DIR}/embedded_${name}.cpp)
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
  set_source_files_properties(${source} PROPERTIES OBJECT_DEPENDS "${paths}")
  target_sources(${target} PRIVATE ${source})
endfunction()
