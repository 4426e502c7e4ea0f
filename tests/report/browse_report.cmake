# Builds a tower of two in the simulated cell and opens its report in a browser.
#   cmake -DSTONESTACK=... -DFOLDER=... -P browse_report.cmake
file(REMOVE_RECURSE "${FOLDER}")
execute_process(COMMAND "${STONESTACK}" run --robot ur10 --seed 1 --per-run 2 --out "${FOLDER}" COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND python3 "${CMAKE_CURRENT_LIST_DIR}/browse_report.py" "${FOLDER}/report.html" "${FOLDER}/page.png"
  COMMAND_ERROR_IS_FATAL ANY)
