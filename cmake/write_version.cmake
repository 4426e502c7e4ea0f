# cmake -DROOT=... -DVERSION=... -DFILE=... -P write_version.cmake: which sources a program was made of, for its
# records. Written only when it has changed, so that nothing else is built anew.
cmake_policy(VERSION 3.25)
execute_process(COMMAND git -C "${ROOT}" describe --always --dirty --abbrev=9 --match=
  OUTPUT_VARIABLE commit ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
set(text "${VERSION}")
if(commit)
  string(APPEND text " (${commit})")
endif()
file(CONFIGURE OUTPUT "${FILE}" CONTENT
  "#include \"version.hpp\"\n\nnamespace stonestack::apps {\n\nconst char* program_version() {\n  return \"@text@\";\n}\n\n}  // namespace stonestack::apps\n" @ONLY)
