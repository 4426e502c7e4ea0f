# Install and export: find_package(stonestack) gives stonestack::stonestack. tests/house/consumer proves it from outside.
include(CMakePackageConfigHelpers)
install(TARGETS stonestack EXPORT stonestackTargets FILE_SET HEADERS)
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}")
install(DIRECTORY "${PROJECT_SOURCE_DIR}/data/" DESTINATION "${CMAKE_INSTALL_DATADIR}/stonestack")
install(EXPORT stonestackTargets NAMESPACE stonestack:: DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/stonestack")
file(WRITE "${CMAKE_BINARY_DIR}/stonestackConfig.cmake" [=[
include(CMakeFindDependencyMacro)
find_dependency(Eigen3 3.4 NO_MODULE)
include("${CMAKE_CURRENT_LIST_DIR}/stonestackTargets.cmake")
]=])
write_basic_package_version_file("${CMAKE_BINARY_DIR}/stonestackConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_BINARY_DIR}/stonestackConfig.cmake" "${CMAKE_BINARY_DIR}/stonestackConfigVersion.cmake"
  DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/stonestack")
