// Empty: the source that CMake asks for where a precompiled header is made (cmake/test.cmake).
