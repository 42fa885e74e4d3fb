# What every target of the project shares: language, warnings, sanitizers, ccache. Properties sit on targets.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)

find_program(FORELAND_CCACHE ccache)
if(FORELAND_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${FORELAND_CCACHE})
  if(NOT FORELAND_PRECOMPILE STREQUAL "OFF")  # else it would not keep what such headers went into
    set(CMAKE_CXX_COMPILER_LAUNCHER env CCACHE_SLOPPINESS=pch_defines,time_macros ${FORELAND_CCACHE})
  endif()
endif()

add_library(foreland_options INTERFACE)
target_include_directories(foreland_options INTERFACE ${CMAKE_SOURCE_DIR})
# Both ends must compute the same bits: no contraction to fused operations, no fast-math.
target_compile_options(foreland_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>  # false alarms in g++ 12's std::string, GCC bug 105651
  -Wno-psabi  # vectors are passed to nobody who was compiled otherwise
  $<$<CXX_COMPILER_ID:Clang>:-Wreserved-identifier>
  -ffp-contract=off $<$<BOOL:${FORELAND_WARNINGS_AS_ERRORS}>:-Werror>)
# What distributions ask of programs that read foreign bytes: checked copies in the C library, and a table of its functions that is
# read-only once the program runs.
target_compile_options(foreland_options INTERFACE $<$<AND:$<CONFIG:Release>,$<NOT:$<PLATFORM_ID:WASI>>>:SHELL:-U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2>)
target_link_options(foreland_options INTERFACE $<$<PLATFORM_ID:Linux>:-Wl,-z,relro,-z,now>)
if(FORELAND_ARCH AND CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  # Without fused operations: g++ 12 fuses the products and sums of rotations that it makes vectors of, whatever -ffp-contract says.
  target_compile_options(foreland_options INTERFACE -march=${FORELAND_ARCH} -mno-fma)
endif()
if(FORELAND_SANITIZE)
  target_compile_options(foreland_options INTERFACE -fsanitize=${FORELAND_SANITIZE} -fno-sanitize-recover=all
    -fno-omit-frame-pointer
    $<$<CXX_COMPILER_ID:Clang>:-fsanitize-ignorelist=${CMAKE_SOURCE_DIR}/cmake/not_ours.ignorelist>)
  target_link_options(foreland_options INTERFACE -fsanitize=${FORELAND_SANITIZE})
endif()
if(FORELAND_PRECOMPILE STREQUAL "ON")
  target_compile_options(foreland_options INTERFACE $<$<CXX_COMPILER_ID:Clang>:SHELL:-Xclang -fno-pch-timestamp>)
endif()

# Several sources are compiled as one unit (UNITY_BUILD), because most of the time goes into the headers that they all include. Sources
# with options of their own stay alone. What this hides, a missing include or a name that two sources use, is checked without units:
# tools/check_headers.py, clang-tidy's build, and the preset `dev`.
option(FORELAND_UNITY "Compile the sources of a target in units of several" OFF)
# In a unit g++ takes a source for a header (subobject-linkage), and inlines enough of std::string for more of the false alarms above.
set(foreland_unit_options
  $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage;-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread>)
function(foreland_units target)
  if(FORELAND_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 12)
    target_compile_options(${target} PRIVATE ${foreland_unit_options})
  endif()
endfunction()

# Any library may become a part of the shared one (client/c), which shows nothing but its C functions. Code that no other library can
# replace is as fast as a program's own: it needs no table to find itself.
function(foreland_for_shared_library target)
  if(NOT CMAKE_SYSTEM_NAME STREQUAL "WASI")
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  endif()
endfunction()

# foreland_library(NAME SOURCES... [PUBLIC libs] [PRIVATE libs])
function(foreland_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  foreland_for_shared_library(${name})
  target_link_libraries(${name} PUBLIC foreland_options ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  foreland_use_precompiled(${name} precompiled_for_libraries)
  foreland_units(${name})
endfunction()

# foreland_program(NAME SOURCES... LIBS...): an executable in bin/.
function(foreland_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE foreland_options ${ARG_LIBS})
  foreland_use_precompiled(${name} precompiled_for_programs)
  foreland_units(${name})
endfunction()

# Mostly other makers' templates, which do little work themselves: optimised less, they compile in two thirds of the time.
function(foreland_optimised_less target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  set_target_properties(${target} PROPERTIES DISABLE_PRECOMPILE_HEADERS ON)  # which are for one set of such options
endfunction()

# Square roots must not set errno, nor comparisons trap, for loops over them to become vector instructions; results stay the same bits.
function(foreland_vectorised_roots target)
  target_compile_options(${target} PRIVATE -fno-math-errno -fno-trapping-math)
  set_target_properties(${target} PROPERTIES DISABLE_PRECOMPILE_HEADERS ON)  # which are for one set of such options
endfunction()

# For sources that are mostly other makers' templates (Asio, CLI11, JSON) and do little work: clang takes half to two thirds of the time
# to compile them for the sanitizers if it need not optimise.
if(FORELAND_SANITIZE)
  set(foreland_quick -O0)
endif()
function(foreland_quick_under_sanitizers)
  if(FORELAND_SANITIZE)
    set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS ${foreland_quick} SKIP_PRECOMPILE_HEADERS ON)  # which are for one set of options
  endif()
endfunction()

# Sources that take a client's time. In WebAssembly these are compiled for speed that costs little size, and everything else for size
# (cmake/wasm32-wasi.cmake): decision 0053 has the figures.
function(foreland_fast_in_wasm)
  if(CMAKE_SYSTEM_NAME STREQUAL "WASI")
    set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS "-Os")
  endif()
endfunction()

# The inner loops of adaptation and decoding, for speed everywhere. By itself g++ leaves most of the adapter's small functions as calls.
function(foreland_inline_deeply)
  if(CMAKE_SYSTEM_NAME STREQUAL "WASI")
    set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS "-O2")
  elseif(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS
      "--param=inline-unit-growth=400;--param=max-inline-insns-auto=200;--param=max-inline-insns-single=1000;--param=large-function-growth=1000;--param=large-stack-frame-growth=10000")
  endif()
endfunction()
