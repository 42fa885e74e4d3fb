# clang-19 with Debian's wasi-libc and libc++ for wasm32; a reactor module without exceptions.
list(APPEND CMAKE_MODULE_PATH ${CMAKE_CURRENT_LIST_DIR})  # for Platform/WASI.cmake
set(CMAKE_SYSTEM_NAME WASI)
set(CMAKE_SYSTEM_PROCESSOR wasm32)
set(CMAKE_CXX_COMPILER clang++-19)
set(CMAKE_CXX_COMPILER_TARGET wasm32-wasi)
set(CMAKE_AR llvm-ar-19)
set(CMAKE_RANLIB llvm-ranlib-19)
cmake_path(GET CMAKE_CURRENT_LIST_DIR PARENT_PATH root)  # which checks need not name
# Every browser with SIMD has memory.copy, conversions of floats that do not trap, and extension of signs.
set(CMAKE_CXX_FLAGS_INIT "-fno-exceptions -msimd128 -mbulk-memory -mnontrapping-fptoint -msign-ext -fmacro-prefix-map=${root}/=")
# For size, which is what a viewer waits for first; what takes time is compiled for speed (foreland_fast_in_wasm). Optimised when linked, too.
set(CMAKE_CXX_FLAGS_RELEASE "-Oz -flto -fno-rtti -DNDEBUG" CACHE STRING "")
set(CMAKE_EXE_LINKER_FLAGS_INIT "-mexec-model=reactor -fuse-ld=lld -Wl,-mllvm,-enable-merge-functions -Wl,-mllvm,-unroll-threshold=0")
set(CMAKE_CXX_COMPILER_WORKS TRUE)
