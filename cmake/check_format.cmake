# cmake -DROOT=... -P check_format.cmake: every C++ file is as clang-format leaves it.
find_program(CLANG_FORMAT NAMES clang-format-14 clang-format REQUIRED)
file(GLOB_RECURSE files "${ROOT}/include/*.hpp" "${ROOT}/src/*.hpp" "${ROOT}/src/*.cpp" "${ROOT}/apps/*.hpp"
     "${ROOT}/apps/*.cpp" "${ROOT}/mpi/*.hpp" "${ROOT}/mpi/*.cpp" "${ROOT}/benchmarks/*.hpp" "${ROOT}/benchmarks/*.cpp"
     "${ROOT}/tests/*.hpp" "${ROOT}/tests/*.cpp")
execute_process(COMMAND "${CLANG_FORMAT}" --dry-run -Werror ${files} RESULT_VARIABLE result ERROR_VARIABLE problems)
if(NOT result EQUAL 0)
  string(SUBSTRING "${problems}" 0 4000 problems)
  message(FATAL_ERROR "${problems}\nRun clang-format -i on these files.")
endif()
