# The library that lightcook::shaders needs.
find_package(glm REQUIRED)
