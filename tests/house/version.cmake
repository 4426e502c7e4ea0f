# The version is the same in CMakeLists.txt (VERSION), CITATION.cff and CHANGELOG.md, whose first release may be
# "Unreleased".
#   cmake -DROOT=... -DVERSION=... -P version.cmake
cmake_policy(VERSION 3.25)
file(STRINGS "${ROOT}/CITATION.cff" cited REGEX "^version: ")
if(NOT cited STREQUAL "version: ${VERSION}")
  message(FATAL_ERROR "CITATION.cff has \"${cited}\", CMakeLists.txt has ${VERSION}")
endif()
file(STRINGS "${ROOT}/CHANGELOG.md" releases REGEX "^## ")
if(NOT "## ${VERSION}" IN_LIST releases)
  message(FATAL_ERROR "CHANGELOG.md has no release ${VERSION}: ${releases}")
endif()
list(GET releases 0 first)
if(NOT first STREQUAL "## ${VERSION}" AND NOT first STREQUAL "## Unreleased")
  message(FATAL_ERROR "CHANGELOG.md begins with \"${first}\", CMakeLists.txt has ${VERSION}")
endif()
