# Debian packages: ./dev package, or `cpack -G DEB` in the build folder.
#   lightcook         the program, its image module, shader sources, the example, documents
#   liblightcook-dev  headers, static libraries and the CMake package
set(CPACK_PACKAGE_NAME lightcook)
set(CPACK_PACKAGE_VENDOR "lightcook authors")
set(CPACK_PACKAGE_CONTACT "lightcook authors <lightcook@example.org>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Compresses baked lighting into GPU textures and certifies the error")
set(CPACK_PACKAGE_DESCRIPTION "lightcook turns SH light maps, HDR environments and sky gradients into GPU textures, together with
 the shader code that reads them. It opens the files that it wrote, shades them with that code, and reports how far the result is from
 the bake.")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "Headers, static libraries and CMake package of lightcook: encode textures and light maps,
 decode and verify them, use the shader sources from C++.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_GENERATOR DEB)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL runtime development)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME lightcook)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME liblightcook-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
# What cmake/*_dependencies.cmake look for; and the program itself, which the CMake package exports.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "lightcook (= ${PROJECT_VERSION}), pkg-config, libglm-dev, libexpected-dev, libfmt-dev, \
libopenexr-dev, libpng-dev, libopencolorio-dev, libhwy-dev, libzstd-dev, libdraco-dev, libastcenc-dev")
include(CPack)
