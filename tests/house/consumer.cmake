# SANITIZE: sanitizers that the library is built with; a program that uses it needs the same, and the same COMPILER.
# Installs everything, builds a project that knows nothing of this tree against it, and runs the installed programs, also
# after the prefix has been moved.
file(REMOVE_RECURSE "${WORK}")
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGN} failed (${result}):\n${text}")
  endif()
endfunction()

# The installed programs start by themselves, and the command finds the data beside it: a cell that is only there.
function(run_installed prefix)
  run(${CMAKE_COMMAND} -E env --unset=LD_LIBRARY_PATH "${prefix}/bin/stonestack-import" --help)
  if(NOT EXISTS "${prefix}/bin/stonestack")
    return()  # built without PCL
  endif()
  set(command ${CMAKE_COMMAND} -E env --unset=LD_LIBRARY_PATH --unset=STONESTACK_DATA "${prefix}/bin/stonestack")
  run(${command} --version)
  file(COPY_FILE "${prefix}/share/stonestack/cells/loopback-ur10.yaml" "${prefix}/share/stonestack/cells/only-here.yaml")
  execute_process(COMMAND ${command} run --cell no-such-cell RESULT_VARIABLE result OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT result EQUAL 3 OR NOT text MATCHES "only-here")
    message(FATAL_ERROR "${prefix}: the command does not look for data beside itself (${result}):\n${text}")
  endif()
endfunction()

run(${CMAKE_COMMAND} --install "${BUILD}" --prefix "${WORK}/prefix")
if(NOT EXISTS "${WORK}/prefix/share/doc/stonestack/LICENSE")
  message(FATAL_ERROR "LICENSE is not installed")
endif()
if(SANITIZE)
  set(flags "-DCMAKE_CXX_FLAGS=-fsanitize=${SANITIZE} -fno-sanitize=vptr" "-DCMAKE_CXX_COMPILER=${COMPILER}")
endif()
# The example of README is compiled as it stands.
file(READ "${README}" readme)
if(NOT readme MATCHES "```cpp\n(.*)```\n\n```cmake")
  message(FATAL_ERROR "${README} has no C++ example above its CMake example")
endif()
file(WRITE "${WORK}/readme.cpp" "${CMAKE_MATCH_1}")
run(${CMAKE_COMMAND} -S "${CONSUMER}" -B "${WORK}/build" -G Ninja "-DCMAKE_PREFIX_PATH=${WORK}/prefix" -DCMAKE_BUILD_TYPE=Release
  "-DREADME_EXAMPLE=${WORK}/readme.cpp"
  ${flags})
run(${CMAKE_COMMAND} --build "${WORK}/build")
run(${CMAKE_COMMAND} -E env --unset=STONESTACK_DATA "LD_LIBRARY_PATH=${WORK}/prefix/lib/x86_64-linux-gnu:${WORK}/prefix/lib" "${WORK}/build/consumer"
  "${WORK}/prefix/share/stonestack")
file(MAKE_DIRECTORY "${WORK}/readme")
file(CREATE_LINK "${WORK}/prefix/share/stonestack/stones" "${WORK}/readme/rocks" SYMBOLIC)
execute_process(COMMAND ${CMAKE_COMMAND} -E env "LD_LIBRARY_PATH=${WORK}/prefix/lib/x86_64-linux-gnu:${WORK}/prefix/lib" "${WORK}/build/readme"
  WORKING_DIRECTORY "${WORK}/readme" RESULT_VARIABLE result OUTPUT_VARIABLE text ERROR_VARIABLE text)
if(NOT result EQUAL 0 OR NOT text STREQUAL "found a pose\n")
  message(FATAL_ERROR "the example of ${README} found nothing (${result}):\n${text}")
endif()
run_installed("${WORK}/prefix")
file(RENAME "${WORK}/prefix" "${WORK}/moved")
run_installed("${WORK}/moved")
