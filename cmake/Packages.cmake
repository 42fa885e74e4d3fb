# Where `cmake --install` puts what is built, by the file hierarchy standard, and what CPack makes of it: the packages
# foreland, libforeland-client0 and -dev (client/c), and, with the laboratory, foreland-lab. docs/INSTALL.md says how to use both.
include(GNUInstallDirs)
set(CMAKE_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
# PATH gets one name, `foreland`. What it runs lies in libexec: nobody need call that by name, and the laboratory's package adds to it.
set(subcommands_dir ${CMAKE_INSTALL_LIBEXECDIR}/foreland)
set(data_dir ${CMAKE_INSTALL_DATADIR}/foreland)
set(doc_dir ${CMAKE_INSTALL_DATADIR}/doc)

# Programs find each other and their data from where they lie, so an installation can be moved.
cmake_path(RELATIVE_PATH CMAKE_INSTALL_FULL_LIBEXECDIR BASE_DIRECTORY ${CMAKE_INSTALL_FULL_BINDIR} OUTPUT_VARIABLE libexec_from_bin)
cmake_path(RELATIVE_PATH CMAKE_INSTALL_FULL_DATADIR BASE_DIRECTORY ${CMAKE_INSTALL_FULL_LIBEXECDIR}/foreland OUTPUT_VARIABLE data_from_libexec)
target_compile_definitions(foreland PRIVATE FORELAND_SUBCOMMANDS="${libexec_from_bin}/foreland")
target_compile_definitions(foreland-serve PRIVATE FORELAND_DATA="${data_from_libexec}/foreland")
if(FORELAND_LAB)
  target_compile_definitions(foreland_lab_programs PRIVATE FORELAND_DATA="${data_from_libexec}/foreland")
endif()

# Each component but `checkout` is a package.
function(foreland_install_subcommands folder component)
  get_property(programs DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
  list(FILTER programs INCLUDE REGEX "^foreland-")
  install(TARGETS ${programs} RUNTIME DESTINATION ${subcommands_dir} COMPONENT ${component})
  set(${component}_subcommands ${programs} PARENT_SCOPE)
endfunction()

# ---- the product ----
install(TARGETS foreland RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT foreland)
foreland_install_subcommands(apps foreland)
install(FILES README.md DESTINATION ${doc_dir}/foreland COMPONENT foreland)
install(DIRECTORY docs DESTINATION ${doc_dir}/foreland COMPONENT foreland
  FILES_MATCHING PATTERN *.md PATTERN engine_*.svg PATTERN page.jpg
  PATTERN decisions EXCLUDE PATTERN manual EXCLUDE PATTERN MUTATIONS.* EXCLUDE PATTERN THREADS.* EXCLUDE)
install(FILES deploy/haproxy.cfg deploy/haproxy-fleet.cfg deploy/nginx.conf deploy/Caddyfile deploy/prometheus/alerts.yml deploy/grafana/foreland.json DESTINATION ${doc_dir}/foreland/examples COMPONENT foreland)
# Debian's packages name the licence, of which every Debian has the text.
install(FILES LICENSE DESTINATION ${doc_dir}/foreland COMPONENT checkout)

# ---- the laboratory ----
set(packages foreland client client_dev)
if(FORELAND_LAB)
  list(APPEND packages lab)
  foreland_install_subcommands(lab/apps lab)
  install(DIRECTORY lab/experiments DESTINATION ${data_dir}/lab COMPONENT lab)
  install(FILES lab/prices.toml DESTINATION ${data_dir}/lab COMPONENT lab)
  install(FILES lab/README.md DESTINATION ${doc_dir}/foreland-lab COMPONENT lab)
endif()

# ---- what depends on where it is installed ----
get_target_property(abi foreland_c SOVERSION)
set(FORELAND_MAINTAINER "Foreland <founders@foreland.example>" CACHE STRING "Whom packages name as who keeps them: NAME <ADDRESS>")
configure_file(cmake/install_documents.cmake.in ${CMAKE_BINARY_DIR}/install_documents.cmake @ONLY)
foreach(component ${packages})
  set(script ${CMAKE_BINARY_DIR}/install_${component}.cmake)
  configure_file(cmake/install_${component}.cmake.in ${script} @ONLY)
  install(SCRIPT ${script} COMPONENT ${component})
endforeach()

# ---- packages ----
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME foreland)
set(CPACK_PACKAGE_VENDOR Foreland)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS ${CMAKE_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS})
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL ${packages})
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER ${FORELAND_MAINTAINER})

# deb822 has no longer lines than 80.
set(needs "Any processor of this architecture will do; AVX2 and AVX-512 are used where
the processor has them.")
if(FORELAND_ARCH)
  set(needs "They were compiled for processors of the kind ${FORELAND_ARCH}.")
endif()
set(CPACK_DEBIAN_FORELAND_PACKAGE_NAME foreland)
set(CPACK_DEBIAN_FORELAND_DESCRIPTION "streams terrain to remote viewers, keyframe by keyframe
A server computes the view-dependent geometry of a scene at keyframes only,
a little ahead of where the viewer will be, and sends the difference between
two keyframes. A light client, in a browser or without a screen, interpolates
every frame in between.
.
The programs make scenes from elevation data, imagery and models, check and
show them, serve them together with the page that flies over them, and fly by
themselves to measure. A unit for systemd runs the server.
.
${needs}")
set(CPACK_DEBIAN_FORELAND_PACKAGE_SUGGESTS "foreland-lab, haproxy")
set(CPACK_DEBIAN_FORELAND_PACKAGE_CONTROL_EXTRA ${CMAKE_SOURCE_DIR}/deploy/debian/conffiles ${CMAKE_SOURCE_DIR}/deploy/debian/postinst
  ${CMAKE_SOURCE_DIR}/deploy/debian/prerm ${CMAKE_SOURCE_DIR}/deploy/debian/postrm)
set(CPACK_DEBIAN_CLIENT_PACKAGE_NAME libforeland-client${abi})
set(CPACK_DEBIAN_CLIENT_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_CLIENT_PACKAGE_CONTROL_EXTRA ${CMAKE_SOURCE_DIR}/deploy/debian/triggers)
set(CPACK_DEBIAN_CLIENT_DESCRIPTION "client of foreland for other engines: shared library
The library connects to a server of foreland, and gives terrain as meshes to
draw and heights to ask for. Its interface is of C.
.
${needs}")
set(CPACK_DEBIAN_CLIENT_DEV_PACKAGE_NAME libforeland-client-dev)
set(CPACK_DEBIAN_CLIENT_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_CLIENT_DEV_PACKAGE_DEPENDS "libforeland-client${abi} (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_CLIENT_DEV_DESCRIPTION "client of foreland for other engines: what programs are built with
The header foreland.h, with all that there is to know of the interface, and
what pkg-config and CMake ask for.")
set(CPACK_DEBIAN_LAB_PACKAGE_NAME foreland-lab)
set(CPACK_DEBIAN_LAB_DESCRIPTION "laboratory of foreland: benchmarks and experiments
The programs are `foreland bench`, which measures the engine beside named
rivals and runs experiments in virtual time, and `foreland link`, which makes
connections to a server as slow as over a real network.
.
${needs}")
set(CPACK_DEBIAN_LAB_PACKAGE_DEPENDS "foreland (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_LAB_PACKAGE_RECOMMENDS "nodejs (>= 18)")
include(CPack)
