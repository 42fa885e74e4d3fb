# Library headers that many sources include are parsed once instead of once for each source:
#   ON     for all sources; for the sanitizers' and the fuzzers' builds
#   TESTS  for the tests alone; for the release build, which so still shows a missing include in any source that is shipped
# A precompiled header hides a missing include. tools/check_headers.py compiles without any.
set(FORELAND_PRECOMPILE "OFF" CACHE STRING "Parse library headers once: OFF, TESTS or ON")

set(standard_headers <algorithm> <array> <atomic> <bit> <chrono> <cmath> <cstdint> <cstdio> <cstring> <deque> <filesystem> <fstream> <functional>
  <limits> <map> <memory> <mutex> <numbers> <optional> <random> <set> <span> <sstream> <string> <string_view> <thread> <tuple> <utility> <variant> <vector>)

# Sets `out` if the header NAME is to be used in this build.
function(foreland_is_precompiled name out)
  if(FORELAND_PRECOMPILE STREQUAL "ON" OR (FORELAND_PRECOMPILE STREQUAL "TESTS" AND name STREQUAL "precompiled_for_tests"))
    set(${out} TRUE PARENT_SCOPE)
  else()
    set(${out} FALSE PARENT_SCOPE)
  endif()
endfunction()

# foreland_precompiled(NAME HEADERS LIBS... [OPTIONS...]): what foreland_use_precompiled(TARGET NAME) names. Options must be those of
# the targets that use it.
function(foreland_precompiled name)
  cmake_parse_arguments(ARG "" "" "HEADERS;LIBS;OPTIONS" ${ARGN})
  foreland_is_precompiled(${name} used)
  if(used)
    set(unit ${CMAKE_BINARY_DIR}/precompiled/${name}.cpp)
    file(CONFIGURE OUTPUT ${unit} CONTENT "")
    add_library(${name} OBJECT ${unit})
    target_link_libraries(${name} PRIVATE foreland_options ${ARG_LIBS})
    target_compile_options(${name} PRIVATE ${ARG_OPTIONS})
    target_precompile_headers(${name} PRIVATE ${standard_headers} ${ARG_HEADERS})
  endif()
endfunction()

function(foreland_use_precompiled target name)
  foreland_is_precompiled(${name} used)
  if(used)
    target_precompile_headers(${target} REUSE_FROM ${name})
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)  # which ccache asks for
  endif()
endfunction()
