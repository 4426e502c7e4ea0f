# Installs the packages that packages.cmake made into a fresh root of Debian 12, as apt does it for a user, and runs command and
# Python module in there. Skipped unless STONESTACK_FRESH_ROOT is set: it loads some hundred packages.
#   STONESTACK_FRESH_ROOT=1 cmake -DPACKAGES=... -P fresh_root.cmake
set(mirror http://deb.debian.org/debian)
if(NOT DEFINED ENV{STONESTACK_FRESH_ROOT})
  message("skipped: STONESTACK_FRESH_ROOT is not set")
  return()
endif()
find_program(MMDEBSTRAP mmdebstrap)
execute_process(COMMAND id -u OUTPUT_VARIABLE user OUTPUT_STRIP_TRAILING_WHITESPACE)
if(NOT MMDEBSTRAP OR NOT user EQUAL 0)
  message("skipped: needs mmdebstrap and root")
  return()
endif()
file(DOWNLOAD ${mirror}/dists/bookworm/Release STATUS status TIMEOUT 30)
list(GET status 0 code)
if(NOT code EQUAL 0)
  message("skipped: ${mirror} is out of reach: ${status}")
  return()
endif()
file(GLOB packages "${PACKAGES}/*.deb")
if(NOT packages)
  message(FATAL_ERROR "no packages in ${PACKAGES}: run house.packages first")
endif()
list(JOIN packages " " files)
set(wanted "apt-get install --yes --no-install-recommends /tmp/packages/*.deb"
  "stonestack --version"
  "cd / && stonestack search --stones all --levels 1"
  "ldconfig -p | grep libstonestack.so.0"
  "zcat /usr/share/man/man1/stonestack.1.gz | grep -q SYNOPSIS")
if(packages MATCHES "/python3-stonestack_")
  list(APPEND wanted "cd / && python3 -c 'import stonestack'"
    "cd / && python3 -c 'print(__import__(\"stonestack\").search(stones=\"limestone_1\").placements[0].stone)'")
endif()
if(packages MATCHES "/stonestack-mpi_")
  list(APPEND wanted "stonestack-mpi --version")
endif()
list(APPEND wanted "apt-get remove --yes libstonestack0 && ! ldconfig -p | grep libstonestack")
set(commands "")
foreach(command IN LISTS wanted)
  string(REPLACE "'" "'\\''" quoted "${command}")
  list(APPEND commands "--customize-hook=chroot \"$1\" sh -ec '${quoted}'")
endforeach()
execute_process(COMMAND "${MMDEBSTRAP}" --mode=root --variant=apt --format=null "--customize-hook=mkdir \"$1/tmp/packages\""
    "--customize-hook=copy-in ${files} /tmp/packages" ${commands} bookworm /dev/null ${mirror}
  RESULT_VARIABLE result OUTPUT_VARIABLE text ERROR_VARIABLE text)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "the packages do not work in a fresh root (${result}):\n${text}")
endif()
message("${text}")
