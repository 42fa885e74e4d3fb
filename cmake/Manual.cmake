# `manual` makes manual pages, shell completion and the schema of serve.toml in ${CMAKE_BINARY_DIR}/share, of what the programs say of
# their options and of docs/manual/; docs/MANUAL.md, which is made of the same, is checked in tests/manual/.
find_package(Python3 3.11 REQUIRED COMPONENTS Interpreter)

set(FORELAND_MANUAL_ARGUMENTS ${CMAKE_RUNTIME_OUTPUT_DIRECTORY})
get_property(foreland_described DIRECTORY apps PROPERTY BUILDSYSTEM_TARGETS)
list(FILTER foreland_described INCLUDE REGEX "^foreland(-|$)")
if(FORELAND_LAB)
  list(APPEND foreland_described foreland-link foreland-bench)
else()
  list(APPEND FORELAND_MANUAL_ARGUMENTS --without-laboratory)
endif()

set(foreland_manual_sources docs/manual/strategies.md tools/make_manual.py)
foreach(module completion man markdown pages schema table)
  list(APPEND foreland_manual_sources tools/manual/${module}.py)
endforeach()
foreach(program ${foreland_described})
  string(REGEX REPLACE "^foreland-" "" word ${program})
  list(APPEND foreland_manual_sources docs/manual/${word}.md)
endforeach()
list(TRANSFORM foreland_manual_sources PREPEND ${CMAKE_SOURCE_DIR}/)

set(foreland_manual_made ${CMAKE_BINARY_DIR}/share/foreland/serve.schema.json)  # the last of all
add_custom_command(OUTPUT ${foreland_manual_made}
  COMMAND Python3::Interpreter -B ${CMAKE_SOURCE_DIR}/tools/make_manual.py ${FORELAND_MANUAL_ARGUMENTS} --out ${CMAKE_BINARY_DIR}/share
  DEPENDS ${foreland_described} ${foreland_manual_sources}
  COMMENT "Making manual pages and shell completion" VERBATIM)
add_custom_target(manual ALL DEPENDS ${foreland_manual_made})
