# Headers of other makers that many sources include, parsed once instead of once a source. Only for builds that are made to be tested
# (the presets asan and tsan): with them a source may forget an include, which every other build shows, and tools/check_headers.py.
option(FORELAND_PRECOMPILE "Parse the headers of the libraries once" OFF)

set(standard_headers <algorithm> <array> <atomic> <bit> <chrono> <cmath> <cstdint> <cstdio> <cstring> <deque> <filesystem> <fstream> <functional>
  <limits> <map> <memory> <mutex> <numbers> <optional> <random> <set> <span> <sstream> <string> <string_view> <thread> <tuple> <utility> <variant> <vector>)

# foreland_precompiled(NAME HEADERS LIBS...): what foreland_use_precompiled(TARGET NAME) names.
function(foreland_precompiled name)
  cmake_parse_arguments(ARG "" "" "HEADERS;LIBS" ${ARGN})
  if(FORELAND_PRECOMPILE)
    set(unit ${CMAKE_BINARY_DIR}/precompiled/${name}.cpp)
    file(CONFIGURE OUTPUT ${unit} CONTENT "")
    add_library(${name} OBJECT ${unit})
    target_link_libraries(${name} PRIVATE foreland_options ${ARG_LIBS})
    target_precompile_headers(${name} PRIVATE ${standard_headers} ${ARG_HEADERS})
  endif()
endfunction()

function(foreland_use_precompiled target name)
  if(FORELAND_PRECOMPILE)
    target_precompile_headers(${target} REUSE_FROM ${name})
  endif()
endfunction()
