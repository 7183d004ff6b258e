# GoogleTest's headers are a third of what compiling a test costs, nlohmann/json and fmt a third of one that reads what was cooked: a
# precompiled header holds them. Tests are built with -O2 in release builds: none of them runs faster with -O3.
function(quick_to_build program)
  cmake_parse_arguments(ARG "JSON" "" "" ${ARGN})
  target_precompile_headers(${program} PRIVATE <gmock/gmock.h>)
  if(ARG_JSON)
    target_precompile_headers(${program} PRIVATE <nlohmann/json.hpp> <fmt/format.h>)
  endif()
  # Tests that read JSON run whole programs and compute little themselves.
  target_compile_options(${program} PRIVATE $<$<CONFIG:Release>:$<IF:$<BOOL:${ARG_JSON}>,-O1,-O2>>)
endfunction()

# lightcook_test(<module> SOURCES a_test.cpp... [OPENIMAGEIO b_test.cpp...] [NOT_SANITIZED c_test.cpp...] [LIBRARIES more...]
#                [DEFINITIONS name=value...] [JSON])
# One GoogleTest program a module, build/<preset>/tests/<module>/<module>_tests; ctest knows each of its tests by name.
#   OPENIMAGEIO    sources that call OpenImageIO. They make a program of their own, <module>_openimageio_tests: loading that library and
#                  the 250 others that it needs takes 0.3 s, and ctest starts one process a test
#   NOT_SANITIZED  sources left out of the sanitizers' builds: they run for minutes there, over code that others run on worse input
#   JSON           the sources include nlohmann/json.hpp and fmt/format.h
# Suites with Soak in their name carry the label "soak": ./dev test leaves them out, ./dev soak runs them with LIGHTCOOK_SOAK=1.
function(lightcook_test module)
  cmake_parse_arguments(ARG "JSON" "" "SOURCES;OPENIMAGEIO;NOT_SANITIZED;LIBRARIES;DEFINITIONS" ${ARGN})
  if(NOT LIGHTCOOK_SANITIZE)
    list(APPEND ARG_SOURCES ${ARG_NOT_SANITIZED})
  endif()
  add_executable(${module}_tests ${ARG_SOURCES})
  set(programs ${module}_tests)
  if(ARG_OPENIMAGEIO)
    add_executable(${module}_openimageio_tests ${ARG_OPENIMAGEIO})
    target_link_libraries(${module}_openimageio_tests PRIVATE PkgConfig::OpenImageIO)
    add_dependencies(${module}_tests ${module}_openimageio_tests)
    list(APPEND programs ${module}_openimageio_tests)
  endif()
  set(json)
  if(ARG_JSON)
    set(json JSON)
  endif()
  foreach(program ${programs})
    target_link_libraries(${program} PRIVATE project_options ${ARG_LIBRARIES} GTest::gmock GTest::gtest_main)
    if(TARGET ${module})
      target_link_libraries(${program} PRIVATE ${module})
    endif()
    target_compile_definitions(${program} PRIVATE
      LIGHTCOOK_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
      LIGHTCOOK_SHARED_DATA="${PROJECT_SOURCE_DIR}/../shared/data"
      ${ARG_DEFINITIONS})
    quick_to_build(${program} ${json})
    link_images_beside(${program})
    gtest_discover_tests(${program} TEST_FILTER "-*Soak*" DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 300)
    gtest_discover_tests(${program} TEST_FILTER "*Soak*" TEST_LIST ${program}_soak DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 7200 LABELS soak)
  endforeach()
endfunction()
