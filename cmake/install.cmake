# `cmake --install build/release --prefix DIR` and, through cmake/package.cmake, the Debian packages.
#   bin/lightcook                    the program; it finds all else relative to itself
#   bin/lightcook-read               what decodes foreign files for it
#   lib/lightcook/                   lightcook_images.so, which the program loads when it opens a picture
#   share/lightcook/                 shader sources, the examples, the npm package of loaders
#   share/man, share/bash-completion, share/zsh, share/fish, share/doc/lightcook
#   include/lightcook/               public headers: #include "lightcook/compress/encode.h"
#   lib/liblightcook_*.a             static libraries
#   lib/cmake/lightcook/             find_package(lightcook), with a component for each of lightcook::program, ::encode, ::shaders, ::verify
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# --- runtime: what somebody needs who cooks scenes --------------------------------------------------------------------------------------

install(TARGETS lightcook EXPORT lightcook_program RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime)
set_target_properties(lightcook PROPERTIES EXPORT_NAME program)
install(TARGETS lightcook-read RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime)
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

# Each component that users name has the libraries listed here; it needs those of the components before it.
set(libraries_of_shaders project_options shaders)
set(libraries_of_encode lighting textures compress)
set(libraries_of_verify formats verify)
set(export_name_of_compress encode)
foreach(component shaders encode verify)
  foreach(library ${libraries_of_${component}})
    if(NOT library STREQUAL project_options)
      set(export_name ${library})
      if(DEFINED export_name_of_${library})
        set(export_name ${export_name_of_${library}})
      endif()
      add_library(lightcook::${export_name} ALIAS ${library})
      set_target_properties(${library} PROPERTIES EXPORT_NAME ${export_name} OUTPUT_NAME lightcook_${library})
    endif()
  endforeach()
  install(TARGETS ${libraries_of_${component}} EXPORT lightcook_${component}
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
endforeach()
set_target_properties(project_options PROPERTIES EXPORT_NAME options)

# The modules' root headers and whatever they include, found when it is installed: cmake/install_headers.cmake.
install(CODE "
  set(source \"${PROJECT_SOURCE_DIR}\")
  set(modules lighting formats compress shaders verify)
  set(rewritten \"${PROJECT_BINARY_DIR}/package/include\")
  set(destination \"\${CMAKE_INSTALL_PREFIX}/include/lightcook\")
  include(\"${PROJECT_SOURCE_DIR}/cmake/install_headers.cmake\")" COMPONENT development)

# Not CMAKE_INSTALL_LIBDIR: a project without a language looks in no folder of an architecture.
set(package_dir lib/cmake/lightcook)
configure_package_config_file(cmake/lightcookConfig.cmake.in ${PROJECT_BINARY_DIR}/package/lightcookConfig.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/package/lightcookConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/package/lightcookConfig.cmake ${PROJECT_BINARY_DIR}/package/lightcookConfigVersion.cmake
  DESTINATION ${package_dir} COMPONENT runtime)
install(EXPORT lightcook_program NAMESPACE lightcook:: DESTINATION ${package_dir} COMPONENT runtime)
foreach(component shaders encode verify)
  install(EXPORT lightcook_${component} NAMESPACE lightcook:: DESTINATION ${package_dir} COMPONENT development)
  install(FILES cmake/${component}_dependencies.cmake DESTINATION ${package_dir} COMPONENT development)
endforeach()
