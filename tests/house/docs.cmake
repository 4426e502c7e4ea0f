# Makes the documentation site as ./dev docs does, in a folder of its own: a warning of Doxygen is an error, and so is a
# link of the site that leads nowhere.
#   cmake -DROOT=... -DWORK=... -DPYTHON3=... -P docs.cmake
find_program(DOXYGEN doxygen)
if(NOT DOXYGEN)
  message("skipped: doxygen is not installed (./dev docs installs it)")
  return()
endif()
file(REMOVE_RECURSE "${WORK}")
file(MAKE_DIRECTORY "${WORK}")
file(READ "${ROOT}/docs/Doxyfile" settings)
file(WRITE "${WORK}/Doxyfile" "${settings}\nOUTPUT_DIRECTORY = \"${WORK}\"\n")
foreach(command "${DOXYGEN};${WORK}/Doxyfile" "${PYTHON3};-B;${ROOT}/tests/house/check_site.py;${WORK}/html")
  execute_process(COMMAND ${command} WORKING_DIRECTORY "${ROOT}" RESULT_VARIABLE result OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${command} failed (${result}):\n${text}")
  endif()
  message("${text}")
endforeach()
