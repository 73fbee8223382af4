# What `cmake --install` leaves: commands, solvers, report scripts, scenes, and for a participant of one's own the
# library libsluice with the headers that coupler/coupler.hpp needs, found by find_package(sluice) and pkg-config; for
# one in C or Python libsluice_c with sluice.h and sluice.py.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# The library for participants outside of this project: all our archives in one, so that its users need none of what
# they link. The archives are on its link line for the sake of that.
sluice_archives(sluice_coupler parts)
add_library(sluice_shared SHARED)
foreach(part sluice_coupler ${parts})
  target_sources(sluice_shared PRIVATE $<TARGET_OBJECTS:${part}>)
endforeach()
target_link_libraries(sluice_shared PUBLIC yaml-cpp PRIVATE sluice_coupler)
target_compile_features(sluice_shared PUBLIC cxx_std_20)
target_include_directories(sluice_shared INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/sluice>)
set_target_properties(sluice_shared PROPERTIES OUTPUT_NAME sluice EXPORT_NAME coupler LINKER_LANGUAGE CXX
  VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
  LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)

# The public headers: coupler.hpp and whatever it includes of ours, installed under the names they are included by.
set(headers coupler/coupler.hpp)
set(queue ${headers})
while(queue)
  list(POP_FRONT queue header)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${header})
  file(STRINGS ${CMAKE_SOURCE_DIR}/${header} lines REGEX "^#include \"coupler/")
  foreach(line ${lines})
    string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" included "${line}")
    if(NOT included IN_LIST headers)
      list(APPEND headers ${included})
      list(APPEND queue ${included})
    endif()
  endforeach()
endwhile()
foreach(header ${headers})
  get_filename_component(folder ${header} DIRECTORY)
  install(FILES ${CMAKE_SOURCE_DIR}/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/sluice/${folder})
endforeach()

# Commands. From the place of `sluice` solvers are looked for beside it, its own files (report scripts and the like) in
# ../share/sluice: there they lie in the build too.
install(TARGETS sluice sluice_replay RUNTIME DESTINATION bin)
foreach(solver ${SLUICE_SOLVERS})
  if(TARGET ${solver}.choose)
    install(TARGETS ${solver}.choose RUNTIME DESTINATION bin)
    install(TARGETS ${solver} RUNTIME DESTINATION lib/sluice/x86-64)
    foreach(level ${SLUICE_LEVELS})
      install(TARGETS ${solver}.${level} RUNTIME DESTINATION lib/sluice/${level})
    endforeach()
  else()
    install(TARGETS ${solver} RUNTIME DESTINATION bin)
  endif()
endforeach()
# An adapter to somebody else's solver is built where that is. It is not in a portable build, which is for a package of
# ours alone: what it links has another licence.
set(built ${SLUICE_SOLVERS})
set(left_out "")
if(TARGET liggghts)
  list(APPEND built liggghts)
  install(TARGETS liggghts RUNTIME DESTINATION bin)
else()
  set(left_out "liggghts libliggghts-dev\n")
endif()
string(REPLACE ";" "\n" lines "${built}")
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/share/sluice/solvers CONTENT "${lines}\n")
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/share/sluice/left_out CONTENT "${left_out}")
install(DIRECTORY ${CMAKE_BINARY_DIR}/share/sluice DESTINATION share PATTERN __pycache__ EXCLUDE)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/configs/ DESTINATION share/sluice/configs FILES_MATCHING PATTERN "*.yaml")
install(FILES ${CMAKE_SOURCE_DIR}/LICENSE DESTINATION share/doc/sluice RENAME copyright)
install(FILES ${CMAKE_SOURCE_DIR}/README.md DESTINATION share/doc/sluice)
if(EXISTS ${CMAKE_SOURCE_DIR}/coupler/cli/completion/sluice.bash)
  install(FILES ${CMAKE_SOURCE_DIR}/coupler/cli/completion/sluice.bash DESTINATION share/bash-completion/completions
          RENAME sluice)
endif()

# For C and Python: sluice.h, libsluice_c, sluice.py where Debian's python3 looks for it if the prefix is /usr.
target_include_directories(sluice_c INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/sluice>)
install(FILES ${CMAKE_SOURCE_DIR}/coupler/bindings/sluice.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/sluice)
install(FILES ${CMAKE_SOURCE_DIR}/coupler/bindings/python/sluice.py DESTINATION lib/python3/dist-packages)

# find_package(sluice) and its targets sluice::coupler and sluice::c.
install(TARGETS sluice_shared sluice_c EXPORT sluice LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
set(cmake_folder ${CMAKE_INSTALL_LIBDIR}/cmake/sluice)
install(EXPORT sluice NAMESPACE sluice:: FILE sluice-targets.cmake DESTINATION ${cmake_folder})
configure_package_config_file(${CMAKE_SOURCE_DIR}/coupler/packaging/sluice-config.cmake.in
  ${CMAKE_BINARY_DIR}/packaging/sluice-config.cmake INSTALL_DESTINATION ${cmake_folder}
  NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/packaging/sluice-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/packaging/sluice-config.cmake
              ${CMAKE_BINARY_DIR}/packaging/sluice-config-version.cmake DESTINATION ${cmake_folder})

# pkg-config, by paths relative to its own file: --prefix may differ from the one configured with.
file(RELATIVE_PATH to_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" to_prefix "${to_prefix}")
foreach(library sluice sluice_c)
  configure_file(${CMAKE_SOURCE_DIR}/coupler/packaging/${library}.pc.in ${CMAKE_BINARY_DIR}/packaging/${library}.pc @ONLY)
  install(FILES ${CMAKE_BINARY_DIR}/packaging/${library}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()
