# Tests are a few executables of many sources: a process for each case would start a thousand times, and make its scenes as often.
#   foreland_test_executable(NAME [SHARDS N] [THREADS])   declares one; ctest runs it as N processes, each with its share of the cases
#   foreland_test_sources(NAME SOURCES... [ALONE...] [LIBS...] [PROGRAMS...])   adds a folder's tests to it, and the programs that these run
# THREADS marks what ./check also runs under ThreadSanitizer. Every process writes its cases to test_results/; tools/test_counts.py counts them.
find_package(GTest REQUIRED)
find_package(rapidcheck REQUIRED)

add_library(foreland_test_support INTERFACE)
target_include_directories(foreland_test_support INTERFACE ${CMAKE_SOURCE_DIR})
target_compile_definitions(foreland_test_support INTERFACE FORELAND_SOURCE_DIR="${CMAKE_SOURCE_DIR}" FORELAND_BIN_DIR="${CMAKE_BINARY_DIR}/bin")
target_link_libraries(foreland_test_support INTERFACE foreland_options GTest::gtest GTest::gtest_main rapidcheck)
# What is tested has the build's own optimisation; the tests themselves need not.
set(test_options $<$<CONFIG:Release>:-O1>)
foreland_precompiled(precompiled_for_tests HEADERS <glm/geometric.hpp> <glm/vec2.hpp> <glm/vec3.hpp> <gtest/gtest.h> <rapidcheck.h>
  LIBS foreland_glm foreland_test_support OPTIONS ${test_options})

# What ./check builds under the sanitizers: all test executables and the programs that they run; those marked with THREADS.
add_custom_target(all_tests)
add_custom_target(threads_tests)

function(foreland_test_executable name)
  cmake_parse_arguments(ARG "THREADS" "SHARDS" "" ${ARGN})
  add_executable(${name})
  target_link_libraries(${name} PRIVATE foreland_test_support)
  target_compile_options(${name} PRIVATE ${test_options})
  foreland_use_precompiled(${name} precompiled_for_tests)
  add_dependencies(all_tests ${name})
  set(label plain)
  if(ARG_THREADS)
    add_dependencies(threads_tests ${name})
    set(label threads)
  endif()
  if(NOT ARG_SHARDS)
    set(ARG_SHARDS 1)
  endif()
  foreach(number RANGE 1 ${ARG_SHARDS})
    math(EXPR index "${number} - 1")
    add_test(NAME ${name}.${number} COMMAND ${name} --gtest_output=xml:${CMAKE_BINARY_DIR}/test_results/${name}.${number}.xml)
    set_tests_properties(${name}.${number} PROPERTIES LABELS ${label} TIMEOUT 1800
      ENVIRONMENT "GTEST_TOTAL_SHARDS=${ARG_SHARDS};GTEST_SHARD_INDEX=${index}")
  endforeach()
endfunction()

# Tests of one folder become units of few sources (FORELAND_UNITY), neighbours in different ones: related tests use the same names.
# Those that still share a name with another of their unit are listed as ALONE.
set(sources_in_test_unit 5)
function(foreland_test_units name)
  if(NOT FORELAND_UNITY)
    return()
  endif()
  set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  string(MD5 folder "${CMAKE_CURRENT_SOURCE_DIR} ${ARGN}")
  list(LENGTH ARGN sources)
  math(EXPR units "(${sources} + ${sources_in_test_unit} - 1) / ${sources_in_test_unit}")
  set(unit 0)
  foreach(source ${ARGN})
    math(EXPR unit "(${unit} + 1) % ${units}")
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE)
    set_source_files_properties(${source} TARGET_DIRECTORY ${name} PROPERTIES UNITY_GROUP ${folder}_${unit})
  endforeach()
  target_compile_options(${name} PRIVATE ${foreland_unit_options})
endfunction()

function(foreland_test_sources name)
  cmake_parse_arguments(ARG "" "" "SOURCES;ALONE;LIBS;PROGRAMS" ${ARGN})
  target_sources(${name} PRIVATE ${ARG_SOURCES} ${ARG_ALONE})
  foreland_test_units(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_LIBS})
  if(ARG_PROGRAMS)
    add_dependencies(${name} ${ARG_PROGRAMS})
  endif()
endfunction()
