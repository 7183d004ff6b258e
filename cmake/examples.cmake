# Examples in C++. They need more than the program does: headers of OpenGL and EGL, libpng.
find_package(OpenGL QUIET COMPONENTS OpenGL EGL)
find_package(PNG QUIET)
if(TARGET OpenGL::OpenGL AND TARGET OpenGL::EGL AND PNG_FOUND)
  add_subdirectory(examples/opengl)
else()
  message(STATUS "examples/opengl left out: no OpenGL, EGL or libpng (Debian: libopengl-dev, libgl-dev, libegl-dev, libpng-dev)")
endif()
