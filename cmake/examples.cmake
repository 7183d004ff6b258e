# Examples in C++. They need more than the program does: headers of OpenGL and EGL.
find_package(OpenGL QUIET COMPONENTS OpenGL EGL)
if(TARGET OpenGL::OpenGL AND TARGET OpenGL::EGL)
  add_subdirectory(examples/opengl)
  # Headers (CLI11, nlohmann/json) are most of what it costs to compile. tests/install compiles each source alone, as users do.
  set_target_properties(lightcook_opengl PROPERTIES UNITY_BUILD ${LIGHTCOOK_UNITY})
else()
  message(STATUS "examples/opengl left out: no OpenGL or EGL (Debian: libopengl-dev, libgl-dev, libegl-dev)")
endif()
