# `cmake --install build/release --prefix DIR` and, through cmake/package.cmake, the Debian packages.
#   bin/lightcook                    the program; it finds all else relative to itself
#   lib/lightcook/                   lightcook_images.so, which the program loads when it opens a picture
#   share/lightcook/                 shader sources, the examples, the npm package of loaders
#   share/man, share/bash-completion, share/zsh, share/fish, share/doc/lightcook
#   include/lightcook/               public headers: #include "compress/encode.h"
#   lib/liblightcook_*.a, lib/cmake/lightcook   find_package(lightcook) with lightcook::encode, ::shaders and ::verify
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# --- runtime: what somebody needs who cooks scenes --------------------------------------------------------------------------------------

install(TARGETS lightcook EXPORT lightcookTargets RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime)
set_target_properties(lightcook PROPERTIES EXPORT_NAME program)
# Not CMAKE_INSTALL_LIBDIR, which may hold an architecture's name: the program looks in ../lib/lightcook (formats/image/image_module.cpp).
install(TARGETS lightcook_images LIBRARY DESTINATION lib/lightcook COMPONENT runtime)
install(DIRECTORY shaders/ DESTINATION ${CMAKE_INSTALL_DATADIR}/lightcook/shaders COMPONENT runtime FILES_MATCHING PATTERN "*.glsl")
install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DATADIR}/lightcook COMPONENT runtime
  PATTERN node_modules EXCLUDE PATTERN dist EXCLUDE)
# The npm package for three.js, Babylon.js and PlayCanvas: examples/web finds it here.
install(DIRECTORY viewer/loaders DESTINATION ${CMAKE_INSTALL_DATADIR}/lightcook/viewer COMPONENT runtime
  PATTERN node_modules EXCLUDE)
# In the folders of the repository, so that links hold.
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime PATTERN "site" EXCLUDE)
install(FILES README.md CHANGELOG.md CONTRIBUTING.md SECURITY.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime)
# Generated from the command table. They belong to the program, so that building it is enough to install it.
add_dependencies(lightcook lightcook_shell_files)
set(generated ${PROJECT_BINARY_DIR}/generated)
install(FILES ${generated}/lightcook.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT runtime)
install(FILES ${generated}/completions/lightcook.bash
  DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT runtime RENAME lightcook)
install(FILES ${generated}/completions/_lightcook DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT runtime)
install(FILES ${generated}/completions/lightcook.fish
  DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d COMPONENT runtime)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT runtime RENAME copyright)

# --- development: what somebody needs who builds on the library -------------------------------------------------------------------------

# The three that users name; lighting and formats come along, since the headers of the others include theirs.
set(installed_modules lighting formats compress shaders verify)
set(export_name_of_compress encode)
foreach(module ${installed_modules})
  set(export_name ${module})
  if(DEFINED export_name_of_${module})
    set(export_name ${export_name_of_${module}})
  endif()
  add_library(lightcook::${export_name} ALIAS ${module})
  set_target_properties(${module} PROPERTIES EXPORT_NAME ${export_name} OUTPUT_NAME lightcook_${module})
endforeach()
set_target_properties(project_options PROPERTIES EXPORT_NAME options)
install(TARGETS ${installed_modules} project_options EXPORT lightcookTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)

# The modules' root headers and whatever they include, found when it is installed: cmake/install_headers.cmake.
install(CODE "
  set(source \"${PROJECT_SOURCE_DIR}\")
  set(modules ${installed_modules})
  set(destination \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}/lightcook\")
  include(\"${PROJECT_SOURCE_DIR}/cmake/install_headers.cmake\")" COMPONENT development)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/lightcook)
configure_package_config_file(cmake/lightcookConfig.cmake.in ${PROJECT_BINARY_DIR}/package/lightcookConfig.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/package/lightcookConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(EXPORT lightcookTargets NAMESPACE lightcook:: DESTINATION ${package_dir} COMPONENT development)
install(FILES ${PROJECT_BINARY_DIR}/package/lightcookConfig.cmake ${PROJECT_BINARY_DIR}/package/lightcookConfigVersion.cmake
  cmake/library_dependencies.cmake DESTINATION ${package_dir} COMPONENT development)
