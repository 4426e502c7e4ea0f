# Opens in a browser the reports of the tower of two and of the wall of three that the tutorial's commands built (house.tutorial).
#   cmake -DTUTORIAL=folder -DFOLDER=... -P browse_report.cmake
file(REMOVE_RECURSE "${FOLDER}")
file(MAKE_DIRECTORY "${FOLDER}")
foreach(structure tower built)
  execute_process(COMMAND python3 "${CMAKE_CURRENT_LIST_DIR}/browse_report.py" "${TUTORIAL}/${structure}/report.html"
    "${FOLDER}/${structure}.png" COMMAND_ERROR_IS_FATAL ANY)
endforeach()
