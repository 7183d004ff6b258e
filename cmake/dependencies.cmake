# Every third-party library. docs/reference/dependencies.md lists the Debian packages.
foreach(component shaders encode verify)
  include(${CMAKE_CURRENT_LIST_DIR}/${component}_dependencies.cmake)
endforeach()

# Used by the program, the image module and the tests, or header-only and invisible in our headers: users of the library need none of these.
pkg_check_modules(OpenImageIO REQUIRED IMPORTED_TARGET OpenImageIO)
pkg_check_modules(HttpLib REQUIRED IMPORTED_TARGET cpp-httplib)
find_package(OpenSSL REQUIRED)
find_package(Eigen3 REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(TBB REQUIRED)
if(LIGHTCOOK_TESTS)
  find_package(Ceres REQUIRED)
  find_package(GTest REQUIRED)
endif()
