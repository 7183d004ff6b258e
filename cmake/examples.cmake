# Examples in C++. They need more than the program does: headers of OpenGL and EGL.
find_package(OpenGL QUIET COMPONENTS OpenGL EGL)
if(TARGET OpenGL::OpenGL AND TARGET OpenGL::EGL)
  # They include as users do, #include "lightcook/formats/gpu_texture.h", and there are no installed headers here: links take their place.
  file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/include/lightcook)
  foreach(module lighting formats)
    file(CREATE_LINK ${PROJECT_SOURCE_DIR}/${module} ${PROJECT_BINARY_DIR}/include/lightcook/${module} SYMBOLIC)
  endforeach()
  add_subdirectory(examples/opengl)
  target_include_directories(lightcook_opengl PRIVATE ${PROJECT_BINARY_DIR}/include)
  # Headers (CLI11, nlohmann/json) are most of what it costs to compile. tests/install compiles each source alone, as users do.
  set_target_properties(lightcook_opengl PROPERTIES UNITY_BUILD ${LIGHTCOOK_UNITY})
else()
  message(STATUS "examples/opengl left out: no OpenGL or EGL (Debian: libopengl-dev, libgl-dev, libegl-dev)")
endif()
