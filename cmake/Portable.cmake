# Header-only libraries that the portable folders use, native and WebAssembly alike. A cross compiler must not see the host's
# /usr/include, so each library is reached through a folder that holds only a link to it.
function(foreland_header_library name header_dir)
  set(only ${CMAKE_BINARY_DIR}/headers/${name})
  file(MAKE_DIRECTORY ${only})
  file(CREATE_LINK /usr/include/${header_dir} ${only}/${header_dir} SYMBOLIC)
  add_library(${name} INTERFACE)
  target_include_directories(${name} SYSTEM INTERFACE ${only})
endfunction()

foreland_header_library(foreland_glm glm)
foreland_header_library(foreland_flatbuffers flatbuffers)
