# Install and export: find_package(stonestack) gives stonestack::stonestack. tests/house/consumer proves it from outside.
include(CMakePackageConfigHelpers)
# Components: library (libstonestack.so), development (headers, CMake and pkg-config files), programs (commands, data).
install(TARGETS stonestack EXPORT stonestackTargets
  LIBRARY COMPONENT library NAMELINK_COMPONENT development
  ARCHIVE COMPONENT development
  FILE_SET HEADERS COMPONENT development)
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT programs)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/data/" DESTINATION "${CMAKE_INSTALL_DATADIR}/stonestack" COMPONENT programs)
install(EXPORT stonestackTargets NAMESPACE stonestack:: DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/stonestack" COMPONENT development)
file(WRITE "${CMAKE_BINARY_DIR}/stonestackConfig.cmake" [=[
include(CMakeFindDependencyMacro)
find_dependency(Eigen3 3.4 NO_MODULE)
include("${CMAKE_CURRENT_LIST_DIR}/stonestackTargets.cmake")
]=])
write_basic_package_version_file("${CMAKE_BINARY_DIR}/stonestackConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_BINARY_DIR}/stonestackConfig.cmake" "${CMAKE_BINARY_DIR}/stonestackConfigVersion.cmake"
  DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/stonestack" COMPONENT development)
file(RELATIVE_PATH to_prefix "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
file(WRITE "${CMAKE_BINARY_DIR}/stonestack.pc" "prefix=\${pcfiledir}/${to_prefix}
libdir=\${prefix}/${CMAKE_INSTALL_LIBDIR}
includedir=\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}

Name: stonestack
Description: ${PROJECT_DESCRIPTION}
Version: ${PROJECT_VERSION}
Requires: eigen3
Libs: -L\${libdir} -lstonestack
Cflags: -I\${includedir}
")
install(FILES "${CMAKE_BINARY_DIR}/stonestack.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig" COMPONENT development)
