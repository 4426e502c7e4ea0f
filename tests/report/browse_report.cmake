# Builds a tower of two and a wall of three in the simulated cell and opens their reports in a browser.
#   cmake -DSTONESTACK=... -DFOLDER=... -P browse_report.cmake
file(REMOVE_RECURSE "${FOLDER}")
execute_process(COMMAND "${STONESTACK}" run --robot ur10 --seed 1 --per-run 2 --out "${FOLDER}/tower" COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${STONESTACK}" run --robot ur10 --seed 2 --per-run 4 --wall 2+1 --out "${FOLDER}/wall" COMMAND_ERROR_IS_FATAL ANY)
foreach(structure tower wall)
  execute_process(COMMAND python3 "${CMAKE_CURRENT_LIST_DIR}/browse_report.py" "${FOLDER}/${structure}/report.html"
    "${FOLDER}/${structure}.png" COMMAND_ERROR_IS_FATAL ANY)
endforeach()
