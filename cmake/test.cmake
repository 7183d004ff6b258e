# A third of the time that a test takes to compile goes into the headers of GoogleTest, and no test gains from -O3.
function(quick_to_build program)
  target_precompile_headers(${program} PRIVATE <gmock/gmock.h>)
  target_compile_options(${program} PRIVATE $<$<CONFIG:Release>:-O2>)
endfunction()

# lightcook_test(<module> SOURCES a_test.cpp ... [LIBRARIES more...]): one GoogleTest program a module; ctest runs each test by itself.
# Suites with Soak in their name carry the label "soak": ./dev test leaves them out, ./dev soak runs them with LIGHTCOOK_SOAK=1.
function(lightcook_test module)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(${module}_tests ${ARG_SOURCES})
  target_link_libraries(${module}_tests PRIVATE project_options ${module} ${ARG_LIBRARIES} GTest::gmock GTest::gtest_main)
  target_compile_definitions(${module}_tests PRIVATE
    LIGHTCOOK_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
    LIGHTCOOK_SHARED_DATA="${PROJECT_SOURCE_DIR}/../shared/data")
  quick_to_build(${module}_tests)
  link_images_beside(${module}_tests)
  gtest_discover_tests(${module}_tests TEST_FILTER "-*Soak*" DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 300)
  gtest_discover_tests(${module}_tests TEST_FILTER "*Soak*" TEST_LIST ${module}_soak DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 7200 LABELS soak)
endfunction()
