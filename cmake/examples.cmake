# Examples in C++. They need more than the program does: headers of OpenGL and EGL.
find_package(OpenGL QUIET COMPONENTS OpenGL EGL)
if(TARGET OpenGL::OpenGL AND TARGET OpenGL::EGL)
  add_subdirectory(examples/opengl)
else()
  message(STATUS "examples/opengl left out: no OpenGL or EGL (Debian: libopengl-dev, libgl-dev, libegl-dev)")
endif()
