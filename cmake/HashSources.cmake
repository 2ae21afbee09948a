# Writes a source file with a hash of sources: cmake -DOUTPUT=FILE -DLIST=FILE -P HashSources.cmake; LIST names them.
file(STRINGS ${LIST} sources)
set(all "")
foreach(source ${sources})
  file(SHA256 ${source} hash)
  string(APPEND all ${hash})
endforeach()
string(SHA256 hash "${all}")
file(WRITE ${OUTPUT} "// Made by cmake/HashSources.cmake.\n"
  "#include <cloudcontact/base/source_hash.h>\n\n"
  "namespace cloudcontact {\n"
  "std::string_view sourceHash() {\n  return \"${hash}\";\n}\n"
  "}  // namespace cloudcontact\n")
