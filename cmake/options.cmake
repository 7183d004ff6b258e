option(LIGHTCOOK_TESTS "Build the tests" ON)
option(LIGHTCOOK_BENCH "Build the benchmarks" ON)
option(LIGHTCOOK_VIEWER "Embed the page of `lightcook view` and that of reports, which need Node 18 or later and the npm packages of viewer/" ON)
option(LIGHTCOOK_UNITY "Compile the sources of modules and of the larger test programs several at a time, in less CPU time")
set(LIGHTCOOK_SANITIZE "" CACHE STRING "Sanitizers: empty, \"address,undefined\" or \"thread\"")

# One set of warnings for all of our targets. Third-party headers come in as SYSTEM and cause none.
# Contraction is off, and there is one minimum instruction set, so that every build computes the same bits. Kernels that gain from wider
# instructions choose them at run time.
set(compile_options
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wcast-align -Wnull-dereference -Werror -ffp-contract=off)
set(link_options)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  list(APPEND compile_options -march=x86-64-v3 -mtune=generic)
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "aarch64|arm64")
  # Highway's NEON target needs the instructions of AES. -Wno-psabi: notes that GCC 10 changed how pairs are passed.
  list(APPEND compile_options -march=armv8-a+crypto -Wno-psabi)
endif()
if(CMAKE_BUILD_TYPE STREQUAL "Release" AND CMAKE_CXX_FLAGS_RELEASE MATCHES "-O3")
  # False positives of GCC 12 at -O3: the first inside std::string (GCC bug 105651), the second inside tl::expected.
  list(APPEND compile_options -Wno-restrict -Wno-null-dereference)
endif()
if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  # Clang's -Wshadow is wider than GCC's: of two sources in one batch, a local name of the one hides a name in the unnamed namespace of the
  # other. The pages are long strings.
  list(APPEND compile_options -Wno-shadow -Wno-overlength-strings)
endif()
if(LIGHTCOOK_SANITIZE)
  # The address sanitizer stops at null pointers, object sizes and virtual tables as well. Leaving these three checks out saves a quarter
  # of the compile time. GCC's flow warnings are off because they report paths that only the instrumentation added.
  list(APPEND compile_options -fsanitize=${LIGHTCOOK_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all
    -fno-sanitize=null,object-size,vptr -Wno-null-dereference)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    list(APPEND compile_options -Wno-maybe-uninitialized)
  endif()
  list(APPEND link_options -fsanitize=${LIGHTCOOK_SANITIZE})
endif()

# Linked by every module. Projects that use the installed library get the include folders and C++20 from it, and none of our flags.
add_library(project_options INTERFACE)
target_compile_features(project_options INTERFACE cxx_std_20)
target_compile_options(project_options INTERFACE "$<BUILD_INTERFACE:${compile_options}>")
target_link_options(project_options INTERFACE "$<BUILD_INTERFACE:${link_options}>")
target_include_directories(project_options INTERFACE
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
  $<INSTALL_INTERFACE:include>)

# For kernels written with Highway, linked after project_options. Highway states the alignment of its loads and stores itself, and the
# sanitizer's check at every access doubles the code.
add_library(vector_options INTERFACE)
# x86-64-v3 has all of AVX2 but not the instructions of AES, without which Highway would take code outside its dispatch for SSSE3: half the
# lanes, and products that are rounded before they are added. No kernel uses them.
target_compile_definitions(vector_options INTERFACE HWY_DISABLE_PCLMUL_AES)
# Eigen would add the numbers of a vector in an order that depends on its width, and so would the bytes. Whoever shares Eigen's types with
# these kernels has to agree: alignment changes too.
target_compile_definitions(vector_options INTERFACE EIGEN_DONT_VECTORIZE)
# Nor are the sanitizers given a copy of every kernel for each instruction set: they check the one for the baseline.
if(LIGHTCOOK_SANITIZE)
  target_compile_options(vector_options INTERFACE -fno-sanitize=alignment)
  target_compile_definitions(vector_options INTERFACE HWY_COMPILE_ONLY_STATIC)
endif()

# Several sources of a target are compiled as one, since their headers and the templates of nlohmann/json cost more than their own code does.
# The names in their unnamed namespaces have to differ. Sources with compile options of their own stay alone, and so do kernels that
# Highway compiles once for each instruction set: hwy/foreach_target.h includes the source again.
if(LIGHTCOOK_UNITY)
  set(CMAKE_UNITY_BUILD ON)
  set(CMAKE_UNITY_BUILD_BATCH_SIZE 8)
  # GCC allows a type of an unnamed namespace as a member in the source itself only, and here sources are included.
  target_compile_options(project_options INTERFACE $<BUILD_INTERFACE:$<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>>)
endif()
