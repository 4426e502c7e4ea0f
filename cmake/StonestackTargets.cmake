# How the house is built: one library target, made of one object library a room. Symbols are hidden but for those of
# public headers; stonestack_internal is an archive of the same objects, with all of them.
#
# What most files include is compiled once, in three precompiled headers: for the library, for programs (with CLI11 and
# json), for tests (with GoogleTest). They hold foreign headers only. A file includes what it uses nevertheless: the
# preset tsan builds without them.
#
#   stonestack_room(NAME core SOURCES error.cpp ... [LINK targets...] [SYSTEM_INCLUDE dirs...])
#     in src/<room>/CMakeLists.txt: compiles the room and adds it to libstonestack.
#   stonestack_link_whole_library(TARGET)
#     links stonestack_internal, all of it and before the target's own objects.
#   stonestack_install_program(TARGET [COMPONENT programs])
#     a program that finds libstonestack from where it lies itself, wherever the prefix is moved to.
#   stonestack_tests(core error_test.cpp ... [OPTIMISED slow_test.cpp ...])
#     in tests/<room>/CMakeLists.txt: one test executable a room, test_<room>. OPTIMISED: files that calculate much themselves.

add_library(stonestack_settings INTERFACE)
target_compile_features(stonestack_settings INTERFACE cxx_std_20)
target_compile_options(stonestack_settings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wcast-qual -Werror
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>  # false alarm on operator+ of strings in GCC 12 (GCC bug 105651)
  $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>  # ccache sees which precompiled header a file reads
  $<$<AND:$<BOOL:${CMAKE_UNITY_BUILD}>,$<CXX_COMPILER_ID:GNU>>:-Wno-subobject-linkage>  # a batch is no header
  "$<$<CXX_COMPILER_ID:Clang>:SHELL:-Xclang -fno-pch-timestamp>"  # one that ccache kept is as good as a new one
  -ffp-contract=off)  # the same seed gives the same tower whatever the compiler fuses
if(STONESTACK_SANITIZE)
  # GCC 12 sees uninitialised and overflowing memory in instrumented code where there is none: warnings stay, errors not.
  # A finding ends the test. No vptr: classes that derive from a library's have hidden type information of their own, which it takes for
  # another class (assimp's IOSystem).
  target_compile_options(stonestack_settings INTERFACE -fsanitize=${STONESTACK_SANITIZE} -fno-sanitize=vptr -fno-sanitize-recover=undefined
    -fno-omit-frame-pointer -Wno-error $<$<CXX_COMPILER_ID:Clang>:-fsanitize-ignorelist=${PROJECT_SOURCE_DIR}/cmake/undefined_behaviour.ignore>)
  target_compile_definitions(stonestack_settings INTERFACE STONESTACK_SANITIZED)  # not every compiler tells by a macro of its own
  # Eigen aligns memory by itself where it sees AddressSanitizer, and PCL's libraries, which are not sanitized, do not:
  # what one of the two allocates the other could not free.
  target_compile_definitions(stonestack_settings INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
  target_link_options(stonestack_settings INTERFACE -fsanitize=${STONESTACK_SANITIZE})
endif()

set(STONESTACK_QUICK_TO_COMPILE $<$<CONFIG:Release>:-O1>)  # for files in which nothing is slow
# Tests spend their time in the library. Compiling them takes less than half as long without optimisation.
set(STONESTACK_QUICKEST_TO_COMPILE $<$<CONFIG:Release,RelWithDebInfo>:-O0>)
set(STONESTACK_PRECOMPILED <Eigen/Cholesky> <Eigen/Core> <Eigen/Eigenvalues> <Eigen/Geometry>
  <algorithm> <array> <atomic> <charconv> <chrono> <cmath> <cstdint> <cstdio> <filesystem> <functional> <limits> <map> <memory> <mutex>
  <numbers> <numeric> <optional> <set> <span> <sstream> <string> <string_view> <thread> <utility> <variant> <vector>)

# stonestack_precompiled(TARGET [LINK targets...] [HEADERS headers...] [OPTIONS options...]): a target whose precompiled header others reuse
# FOR_PROGRAMS: compiled for programs (-fPIE), as the files that reuse it are.
function(stonestack_precompiled target)
  cmake_parse_arguments(SHARED "FOR_PROGRAMS" "" "LINK;HEADERS;OPTIONS" ${ARGN})
  file(CONFIGURE OUTPUT "${CMAKE_CURRENT_BINARY_DIR}/${target}.cpp" CONTENT "namespace stonestack {}\n")
  add_library(${target} OBJECT "${CMAKE_CURRENT_BINARY_DIR}/${target}.cpp")
  target_link_libraries(${target} PRIVATE stonestack_settings Eigen3::Eigen ${SHARED_LINK})
  if(SHARED_FOR_PROGRAMS)
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
    target_compile_options(${target} PRIVATE -fPIE)
  endif()
  target_compile_options(${target} PRIVATE ${SHARED_OPTIONS})
  target_precompile_headers(${target} PRIVATE ${STONESTACK_PRECOMPILED} ${SHARED_HEADERS})
endfunction()

macro(stonestack_library)
  set(CMAKE_CXX_EXTENSIONS OFF)
  set(CMAKE_POSITION_INDEPENDENT_CODE ON)
  set(CMAKE_CXX_VISIBILITY_PRESET hidden)  # public headers say what is not
  stonestack_precompiled(stonestack_precompiled_library)
  add_library(stonestack)
  add_library(stonestack::stonestack ALIAS stonestack)
  file(GLOB_RECURSE STONESTACK_HEADERS CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/include/stonestack/*.hpp")
  target_sources(stonestack PUBLIC FILE_SET HEADERS
    BASE_DIRS "${PROJECT_SOURCE_DIR}/include" FILES ${STONESTACK_HEADERS})
  target_compile_features(stonestack PUBLIC cxx_std_20)
  target_link_libraries(stonestack PUBLIC Eigen3::Eigen PRIVATE $<BUILD_INTERFACE:stonestack_settings>)
  if(STONESTACK_SANITIZE)  # a program without instrumented code needs their runtime, too
    target_link_options(stonestack INTERFACE $<BUILD_INTERFACE:-fsanitize=${STONESTACK_SANITIZE}>)
  endif()
  # The same objects as an archive, for tests and measurements of what the shared library hides.
  add_library(stonestack_internal STATIC)
  target_include_directories(stonestack_internal PUBLIC "${PROJECT_SOURCE_DIR}/include" "${PROJECT_SOURCE_DIR}/src")
  target_link_libraries(stonestack_internal PUBLIC stonestack_settings Eigen3::Eigen)
  set_target_properties(stonestack PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR})
endmacro()

function(stonestack_room)
  cmake_parse_arguments(ROOM "" "NAME" "SOURCES;LINK;SYSTEM_INCLUDE" ${ARGN})
  set(target stonestack_${ROOM_NAME})
  add_library(${target} OBJECT ${ROOM_SOURCES})
  target_include_directories(${target} PRIVATE "${PROJECT_SOURCE_DIR}/include" "${PROJECT_SOURCE_DIR}/src")
  target_include_directories(${target} SYSTEM PRIVATE ${ROOM_SYSTEM_INCLUDE})
  target_link_libraries(${target} PRIVATE stonestack_settings Eigen3::Eigen ${ROOM_LINK})
  target_precompile_headers(${target} REUSE_FROM stonestack_precompiled_library)
  target_sources(stonestack PRIVATE $<TARGET_OBJECTS:${target}>)
  target_link_libraries(stonestack PRIVATE $<BUILD_INTERFACE:${ROOM_LINK}>)
  target_sources(stonestack_internal PRIVATE $<TARGET_OBJECTS:${target}>)
  target_link_libraries(stonestack_internal PRIVATE ${ROOM_LINK})
endfunction()

# Of a template that the library and the program both instantiate the linker keeps the first. With the library first this is the optimised
# one: what is tested and measured is the library as it is shipped.
function(stonestack_link_whole_library target)
  target_link_options(${target} PRIVATE LINKER:--whole-archive $<TARGET_FILE:stonestack_internal> LINKER:--no-whole-archive)
  target_link_libraries(${target} PRIVATE stonestack_internal)
endfunction()

function(stonestack_install_program target)
  cmake_parse_arguments(INSTALLED "" "COMPONENT" "" ${ARGN})
  if(NOT INSTALLED_COMPONENT)
    set(INSTALLED_COMPONENT programs)
  endif()
  file(RELATIVE_PATH to_library "${CMAKE_INSTALL_FULL_BINDIR}" "${CMAKE_INSTALL_FULL_LIBDIR}")
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN/${to_library}")
  install(TARGETS ${target} COMPONENT ${INSTALLED_COMPONENT})
endfunction()

# COST: order of magnitude of its longest tests in seconds; ctest begins with the dearest, so that none of them is left for the end.
function(stonestack_tests room)
  cmake_parse_arguments(TESTS "" "COST" "OPTIMISED" ${ARGN})
  if(NOT TESTS_COST)
    set(TESTS_COST 0)
  endif()
  set(target test_${room})
  add_executable(${target} ${TESTS_UNPARSED_ARGUMENTS} ${TESTS_OPTIMISED})
  set_source_files_properties(${TESTS_OPTIMISED} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON SKIP_PRECOMPILE_HEADERS ON
    COMPILE_OPTIONS ${STONESTACK_QUICK_TO_COMPILE})
  if(STONESTACK_SANITIZE STREQUAL "thread")
    target_sources(${target} PRIVATE "${PROJECT_SOURCE_DIR}/tests/thread_sanitizer.cpp")
    target_link_libraries(${target} PRIVATE TBB::tbb)
  endif()
  target_include_directories(${target} PRIVATE "${PROJECT_SOURCE_DIR}/tests")
  target_compile_definitions(${target} PRIVATE
    STONESTACK_SOURCE_DIR="${PROJECT_SOURCE_DIR}" STONESTACK_BINARY="${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/stonestack")
  if(NOT TARGET stonestack_precompiled_tests)
    stonestack_precompiled(stonestack_precompiled_tests FOR_PROGRAMS LINK GTest::gmock HEADERS <gmock/gmock.h> <gtest/gtest.h>
      OPTIONS ${STONESTACK_QUICKEST_TO_COMPILE})
  endif()
  target_precompile_headers(${target} REUSE_FROM stonestack_precompiled_tests)
  target_compile_options(${target} PRIVATE ${STONESTACK_QUICKEST_TO_COMPILE})
  if(TARGET stonestack_programs)
    add_dependencies(${target} stonestack_programs)
  endif()
  stonestack_link_whole_library(${target})
  target_link_libraries(${target} PRIVATE GTest::gmock GTest::gtest_main)
  gtest_discover_tests(${target} TEST_PREFIX "${room}." DISCOVERY_TIMEOUT 120 PROPERTIES TIMEOUT 900 COST ${TESTS_COST} LABELS ${room})
endfunction()
