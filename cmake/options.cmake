option(LIGHTCOOK_TESTS "Build the tests" ON)
option(LIGHTCOOK_BENCH "Build the benchmarks" ON)
set(LIGHTCOOK_SANITIZE "" CACHE STRING "Sanitizers: empty, \"address,undefined\" or \"thread\"")

# One set of warnings for all of our targets; third-party headers come in as SYSTEM and stay quiet.
add_library(project_options INTERFACE)
target_compile_options(project_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wcast-align -Wnull-dereference -Werror
  # Same bits everywhere: no contraction, one floor of instructions; wider ones are chosen at run time where they were measured.
  -ffp-contract=off)
target_include_directories(project_options INTERFACE ${PROJECT_SOURCE_DIR})
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  target_compile_options(project_options INTERFACE -march=x86-64-v3 -mtune=generic)
endif()
if(CMAKE_BUILD_TYPE STREQUAL "Release" AND CMAKE_CXX_FLAGS_RELEASE MATCHES "-O3")
  # GCC 12 inlines so much at -O3 that it finds the first inside std::string (its bug 105651) and the second inside tl::expected.
  target_compile_options(project_options INTERFACE -Wno-restrict -Wno-null-dereference)
endif()
if(LIGHTCOOK_SANITIZE)
  # What these three look for stops the address sanitizer as well, and they are a quarter of what compiling takes.
  # GCC's flow warnings see paths that only the instrumentation added.
  target_compile_options(project_options INTERFACE -fsanitize=${LIGHTCOOK_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all
    -fno-sanitize=null,object-size,vptr -Wno-null-dereference -Wno-maybe-uninitialized)
  target_link_options(project_options INTERFACE -fsanitize=${LIGHTCOOK_SANITIZE})
endif()

# For kernels in vectors, linked after project_options: Highway says itself how what it loads and stores must lie, and asking again at
# every access doubles the code.
add_library(vector_options INTERFACE)
if(LIGHTCOOK_SANITIZE)
  target_compile_options(vector_options INTERFACE -fno-sanitize=alignment)
endif()
