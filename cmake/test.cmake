# Tests of JSON run whole programs and compute little themselves: -Og, which compiles in two thirds of the time. None of the others runs
# faster with -O3 than with -O2.
# A precompiled header and the sources that use it must agree in -pthread and in the macros that its headers know.
set(test_options -pthread $<$<CONFIG:Release>:-O2>)
set(json_test_options -pthread $<$<CONFIG:Release>:-Og>)
set(test_libraries project_options GTest::gmock GTest::gtest_main)
set(json_test_libraries ${test_libraries} nlohmann_json::nlohmann_json fmt::fmt)
# GoogleTest's headers are a third of what compiling a test costs, nlohmann/json and fmt a third of one that reads what was cooked. Two
# precompiled headers hold them for all test programs. (Each program with one of its own takes a minute more.)
foreach(kind test json_test)
  add_library(${kind}_headers OBJECT ${PROJECT_SOURCE_DIR}/tests/precompiled.cpp)
  target_link_libraries(${kind}_headers PRIVATE ${${kind}_libraries})
  target_compile_options(${kind}_headers PRIVATE ${${kind}_options})
  target_precompile_headers(${kind}_headers PRIVATE <gmock/gmock.h>)
endforeach()
target_precompile_headers(json_test_headers PRIVATE <nlohmann/json.hpp> <fmt/format.h>)

# The clock of ./dev soak, in every test program.
add_library(soak_clock OBJECT ${PROJECT_SOURCE_DIR}/tests/soak/clock.cpp)
target_link_libraries(soak_clock PRIVATE ${test_libraries})
target_compile_options(soak_clock PRIVATE ${test_options})
target_precompile_headers(soak_clock REUSE_FROM test_headers)

# Builds the tests of ./dev soak that nothing else needs: the programs that lightcook_test(... SOAK) makes.
add_custom_target(soak_tests)

# discover_suites(<program> <cost> <soak>): ctest runs each suite of a GoogleTest program, which says itself which ones it has.
#   soak  all suites of the program carry the label "soak"
function(discover_suites program cost soak)
  if(NOT cost)
    set(cost 1)
  endif()
  set(suites ${CMAKE_CURRENT_BINARY_DIR}/${program}_suites.cmake)
  add_custom_command(TARGET ${program} POST_BUILD BYPRODUCTS ${suites}
    COMMAND ${CMAKE_COMMAND} -D PROGRAM=$<TARGET_FILE:${program}> -D OUTPUT=${suites} -D COST=${cost} -D SOAK=${soak}
            -P ${PROJECT_SOURCE_DIR}/cmake/discover_suites.cmake
    VERBATIM)
  set(missing "add_test(${program}_is_not_built false)\n")
  if(soak)
    string(APPEND missing "  set_tests_properties(${program}_is_not_built PROPERTIES LABELS soak)\n")
  endif()
  # No test reads the configuration file of who runs it.
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/${program}_include.cmake
    "set(ENV{XDG_CONFIG_HOME} [=[${PROJECT_BINARY_DIR}/no_configuration]=])\n"
    "if(EXISTS [=[${suites}]=])\n  include([=[${suites}]=])\nelse()\n  ${missing}endif()\n")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${CMAKE_CURRENT_BINARY_DIR}/${program}_include.cmake)
endfunction()

# lightcook_test(<module> [SOAK | PART <name>] SOURCES a_test.cpp... [OPENIMAGEIO b_test.cpp...] [NOT_SANITIZED c_test.cpp...]
#                [LIBRARIES more...] [DEFINITIONS name=value...] [COST number] [JSON] [UNITY])
# One GoogleTest program a module, build/<preset>/tests/<module>/<module>_tests; ctest knows each of its suites by name and runs it as one
# process. So a suite sets up once what its tests share; with a process for each test, all tests take an eighth more CPU time.
#   SOAK           the program <module>_soak_tests: sources that ./dev soak alone needs. Only the target soak_tests builds it
#   PART           the program <module>_<name>_tests, which <module>_tests depends on, but not under the sanitizers of CI (./dev)
#   OPENIMAGEIO    sources that call OpenImageIO. They make a program of their own, <module>_openimageio_tests: loading that library and
#                  the 250 others that it needs takes 0.3 s, and ctest starts one process a suite
#   NOT_SANITIZED  sources left out of the sanitizers' builds: they run for minutes there, over code that others run on worse input
#   UNITY          with LIGHTCOOK_UNITY the sources of a program are compiled several at a time, so names in their unnamed namespaces differ
#   COST           ctest begins with the suites of the largest, so that no long one is left for the end
#   JSON           the sources include nlohmann/json.hpp and fmt/format.h
# Suites with Soak in their name, and all of a SOAK program, carry the label "soak": ./dev test leaves them out, ./dev soak runs them
# (tests/soak).
function(lightcook_test module)
  cmake_parse_arguments(ARG "JSON;UNITY;SOAK" "COST;PART" "SOURCES;OPENIMAGEIO;NOT_SANITIZED;LIBRARIES;DEFINITIONS" ${ARGN})
  if(NOT LIGHTCOOK_SANITIZE)
    list(APPEND ARG_SOURCES ${ARG_NOT_SANITIZED})
  elseif(NOT ARG_SOURCES)
    return()
  endif()
  set(stem ${module})
  if(ARG_SOAK)
    set(stem ${module}_soak)
  elseif(ARG_PART)
    set(stem ${module}_${ARG_PART})
  endif()
  set(main ${stem}_tests)
  add_executable(${main} ${ARG_SOURCES})
  set(programs ${main})
  if(ARG_OPENIMAGEIO)
    add_executable(${stem}_openimageio_tests ${ARG_OPENIMAGEIO})
    target_link_libraries(${stem}_openimageio_tests PRIVATE PkgConfig::OpenImageIO)
    add_dependencies(${main} ${stem}_openimageio_tests)
    list(APPEND programs ${stem}_openimageio_tests)
  endif()
  if(ARG_SOAK)
    set_target_properties(${programs} PROPERTIES EXCLUDE_FROM_ALL ON)
    add_dependencies(soak_tests ${main})
  elseif(ARG_PART AND NOT LIGHTCOOK_SANITIZE)
    add_dependencies(${module}_tests ${main})
  endif()
  if(ARG_UNITY)
    set_target_properties(${programs} PROPERTIES UNITY_BUILD ${LIGHTCOOK_UNITY} UNITY_BUILD_BATCH_SIZE "${CMAKE_UNITY_BUILD_BATCH_SIZE}")
  endif()
  set(kind test)
  if(ARG_JSON)
    set(kind json_test)
  endif()
  foreach(program ${programs})
    target_link_libraries(${program} PRIVATE soak_clock ${${kind}_libraries} ${ARG_LIBRARIES})
    if(TARGET ${module})
      target_link_libraries(${program} PRIVATE ${module})
    endif()
    target_compile_definitions(${program} PRIVATE
      LIGHTCOOK_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
      LIGHTCOOK_SHARED_DATA="${PROJECT_SOURCE_DIR}/../shared/data"
      LIGHTCOOK_TEST_CACHE="${PROJECT_BINARY_DIR}/test_cache"  # of cooks that several tests need and none is about
      ${ARG_DEFINITIONS})
    target_compile_options(${program} PRIVATE ${${kind}_options})
    target_precompile_headers(${program} REUSE_FROM ${kind}_headers)
    link_images_beside(${program})
    discover_suites(${program} "${ARG_COST}" ${ARG_SOAK})
  endforeach()
endfunction()

# lightcook_fuzz(<module> SOURCES fuzz/targets.cpp... [LIBRARIES more...])
# The fuzzers of a module (tests/fuzz/target.h): the tests <module>_fuzz_tests, which take the corpora again, and in the preset `fuzz`
# Clang's libFuzzer on the same targets, build/fuzz/<module>_fuzz.
function(lightcook_fuzz module)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBRARIES" ${ARGN})
  lightcook_test(${module} PART fuzz SOURCES ${ARG_SOURCES} ${PROJECT_SOURCE_DIR}/tests/fuzz/replay_test.cpp LIBRARIES ${ARG_LIBRARIES})
  target_compile_definitions(${module}_fuzz_tests PRIVATE
    LIGHTCOOK_FUZZ_MODULE=${module} LIGHTCOOK_FUZZ_CORPUS="${CMAKE_CURRENT_SOURCE_DIR}/fuzz/corpus")
  if(NOT LIGHTCOOK_SANITIZE MATCHES fuzzer)
    return()
  endif()
  add_executable(${module}_fuzz ${ARG_SOURCES} ${PROJECT_SOURCE_DIR}/tests/fuzz/fuzz_main.cpp)
  target_link_libraries(${module}_fuzz PRIVATE ${module} project_options GTest::gtest ${ARG_LIBRARIES})
  target_link_options(${module}_fuzz PRIVATE -fsanitize=fuzzer)
  set_target_properties(${module}_fuzz PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
endfunction()
