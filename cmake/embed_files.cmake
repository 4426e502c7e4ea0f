# Writes FILES (paths, joined by |) as string constants into OUTPUT: embed_files.cmake is run by src/report/CMakeLists.txt.
#   NAMES: C++ names of the constants, joined by |; NAMESPACE: where they stand.
string(REPLACE "|" ";" files "${FILES}")
string(REPLACE "|" ";" names "${NAMES}")
set(text "#include <string_view>\n\nnamespace ${NAMESPACE} {\n")
foreach(file name IN ZIP_LISTS files names)
  file(READ "${file}" bytes HEX)
  string(REGEX REPLACE "(................................................................)" "\\1\n" lines "${bytes}")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," lines "${lines}")
  string(APPEND text "static const unsigned char ${name}_bytes[] = {\n${lines}\n};\n"
    "extern const std::string_view ${name};\n"
    "const std::string_view ${name}(reinterpret_cast<const char*>(${name}_bytes), sizeof ${name}_bytes);\n")
endforeach()
file(WRITE "${OUTPUT}" "${text}}  // namespace ${NAMESPACE}\n")
