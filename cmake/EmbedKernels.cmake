# Writes kernels as one C++ string: cmake -DOUTPUT=FILE -DNAME=kName -DSOURCES="a.h;b.h;c.cl" -P EmbedKernels.cmake
# The sources come in an order in which each follows what it includes, so their own #include "..."
# lines, and #pragma once, are left out.
set(text "")
foreach(source ${SOURCES})
  file(READ ${source} part)
  string(REGEX REPLACE "#include \"[^\"\n]*\"\n" "" part "${part}")
  string(REPLACE "#pragma once\n" "\n" part "${part}")
  cmake_path(GET source FILENAME name)
  string(APPEND text "#line 1 \"${name}\"\n${part}\n")
endforeach()
file(WRITE ${OUTPUT} "// Made by cmake/EmbedKernels.cmake from kernels/.\n"
  "namespace cloudcontact::opencl {\n"
  "extern const char* const ${NAME};\n"
  "const char* const ${NAME} = R\"kernels(${text})kernels\";\n"
  "}  // namespace cloudcontact::opencl\n")
