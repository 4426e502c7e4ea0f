# Every third-party package, found once. Rooms link the names below.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(PkgConfig REQUIRED)
pkg_check_modules(BULLET REQUIRED IMPORTED_TARGET bullet-float64)  # find_package(Bullet) is the float build
pkg_check_modules(CLP REQUIRED IMPORTED_TARGET clp)
find_package(spdlog REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(CLI11 REQUIRED)
find_package(TBB REQUIRED)
find_package(PNG REQUIRED)
find_package(embree 3 REQUIRED)
find_package(CGAL 5.5 REQUIRED QUIET)  # header only; its targets bring GMP and MPFR
find_package(Threads REQUIRED)
if(STONESTACK_TESTS)
  find_package(GTest REQUIRED)
  pkg_check_modules(MODBUS REQUIRED IMPORTED_TARGET libmodbus)
  include(GoogleTest)
endif()
