# Opens in a browser the reports of the tower of two and of the wall of three that the tutorial's commands built (house.tutorial).
#   cmake -DTUTORIAL=folder -DFOLDER=... -P browse_report.cmake
file(REMOVE_RECURSE "${FOLDER}")
file(MAKE_DIRECTORY "${FOLDER}")
file(READ "${TUTORIAL}/built/result.json" result)
if(NOT result MATCHES "\"wall\": {")
  message(FATAL_ERROR "${TUTORIAL}/built is no wall, whose page has checks of its own")
endif()
foreach(structure tower built)
  execute_process(COMMAND python3 "${CMAKE_CURRENT_LIST_DIR}/browse_report.py" "${TUTORIAL}/${structure}/report.html"
    "${FOLDER}/${structure}.png" COMMAND_ERROR_IS_FATAL ANY)
endforeach()
