# The libraries that lightcook::encode links, for this build and for projects that use an installed lightcook. Some come through pkg-config,
# because their CMake configs are missing or broken on Debian 12: see docs/reference/dependencies.md.
find_package(PkgConfig REQUIRED)
pkg_check_modules(Highway REQUIRED IMPORTED_TARGET libhwy)
pkg_check_modules(Zstd REQUIRED IMPORTED_TARGET libzstd)
find_package(tl-expected REQUIRED)
find_package(fmt REQUIRED)
if(NOT TARGET astcenc)
  find_library(ASTCENC_LIBRARY astcenc REQUIRED)
  find_path(ASTCENC_INCLUDE_DIR astcenc.h REQUIRED)
  add_library(astcenc UNKNOWN IMPORTED)
  set_target_properties(astcenc PROPERTIES
    IMPORTED_LOCATION ${ASTCENC_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${ASTCENC_INCLUDE_DIR}
    INTERFACE_COMPILE_DEFINITIONS ASTCENC_DYNAMIC_LIBRARY)  # without it the header declares C++ functions, and linking fails
endif()
