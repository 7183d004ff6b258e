# Writes the tests of one GoogleTest program for ctest: one for each suite, so that a suite sets up once what its tests share.
#   cmake -D PROGRAM=FILE -D OUTPUT=FILE.cmake [-D COST=NUMBER] [-D SOAK=ON] -P discover_suites.cmake
# Suites with Soak in their name carry the label "soak", with SOAK all do. COST: ctest begins with the tests of the largest.
execute_process(COMMAND ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listing TIMEOUT 60 RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "${PROGRAM} does not list its tests: ${status}")
endif()
# A line of a suite ends in a period, or in a comment after it; its tests are indented.
string(REGEX MATCHALL "\n[^ \n]+\\.[ \n]" suites "\n${listing}")
cmake_path(GET PROGRAM PARENT_PATH folder)
set(tests "")
foreach(suite IN LISTS suites)
  string(REGEX REPLACE "[ \n.]" "" suite "${suite}")
  set(properties "TIMEOUT 900 COST ${COST} WORKING_DIRECTORY ${folder}")
  if(SOAK OR suite MATCHES "Soak")
    set(properties "TIMEOUT 14400 LABELS soak WORKING_DIRECTORY ${folder}")
  endif()
  string(APPEND tests "add_test([=[${suite}]=] [=[${PROGRAM}]=] [=[--gtest_filter=${suite}.*]=])\n"
    "set_tests_properties([=[${suite}]=] PROPERTIES ${properties})\n")
endforeach()
file(WRITE ${OUTPUT} "${tests}")
