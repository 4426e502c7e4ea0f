# The layer check must be able to fail: plant a violation in a copy of the headers and expect to be refused.
file(REMOVE_RECURSE "${WORK}")
file(COPY "${ROOT}/include" "${ROOT}/src" DESTINATION "${WORK}")
file(APPEND "${WORK}/src/core/clock.cpp" "#include \"stonestack/physics/world.hpp\"\n")
execute_process(COMMAND ${CMAKE_COMMAND} -DROOT=${WORK} -P "${ROOT}/cmake/check_layers.cmake"
                RESULT_VARIABLE result ERROR_VARIABLE text OUTPUT_QUIET)
if(result EQUAL 0 OR NOT text MATCHES "core, floor 0")
  message(FATAL_ERROR "a planted violation was not found: ${text}")
endif()
