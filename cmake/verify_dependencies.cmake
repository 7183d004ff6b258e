# The libraries that lightcook::verify links beside those of lightcook::encode: it opens bakes and meshes.
find_package(PkgConfig REQUIRED)
pkg_check_modules(OpenColorIO REQUIRED IMPORTED_TARGET OpenColorIO)
pkg_check_modules(OpenEXR REQUIRED IMPORTED_TARGET OpenEXR)
find_package(PNG REQUIRED)
find_package(draco REQUIRED)
find_package(Threads REQUIRED)
