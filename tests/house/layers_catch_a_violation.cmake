# The layer check must be able to fail: plant violations in a copy of the headers and expect to be refused.
file(REMOVE_RECURSE "${WORK}")
file(COPY "${ROOT}/include" "${ROOT}/src" DESTINATION "${WORK}")
file(APPEND "${WORK}/src/core/clock.cpp" "#include \"physics/world.hpp\"\n")
file(APPEND "${WORK}/src/stacking/believe.cpp" "#include \"stonestack/simulation/simulated_cell.hpp\"\n")
file(APPEND "${WORK}/src/search/descent.cpp" "#include \"simulation/true_world.hpp\"\n")
file(APPEND "${WORK}/src/stacking/learn.cpp" "const char* truth = \"run/simulated-cell/world.json\";\n")
file(APPEND "${WORK}/src/urscript/machine.cpp" "#include \"emulators/ur/controller.hpp\"\n")
file(APPEND "${WORK}/src/motion/grasp/grasp.cpp" "#include \"stonestack/core/clock.hpp\"\n")
file(APPEND "${WORK}/src/core/socket.cpp" "const auto until = std::chrono::system_clock::now();\n")
file(WRITE "${WORK}/tests/core/planted_test.cpp" "const std::string path = testing::TempDir() + \"planted\";\n")
file(WRITE "${WORK}/include/stonestack/search/planted.hpp" "#pragma once\nnamespace stonestack::search {}\n")
execute_process(COMMAND ${CMAKE_COMMAND} -DROOT=${WORK} -P "${ROOT}/cmake/check_layers.cmake"
                RESULT_VARIABLE result ERROR_VARIABLE text OUTPUT_QUIET)
foreach(expected "core, floor 0" "stacking, floor 50" "search, floor 40" "urscript, floor 50" "must not see" "depend on a clock"
        "learn.cpp: only simulation/ reads the truth" "socket.cpp: deadlines go by the steady clock"
        "planted.hpp: what it declares must be" "planted_test.cpp: tests write into")
  if(result EQUAL 0 OR NOT text MATCHES "${expected}")
    message(FATAL_ERROR "a planted violation was not found ('${expected}'): ${text}")
  endif()
endforeach()
