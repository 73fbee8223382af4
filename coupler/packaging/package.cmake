# `cpack` makes one Debian package that runs on every x86-64 processor.
# Depends comes from what the executables link (dpkg-shlibdeps); what `sluice` merely calls is recommended.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME sluice)
set(CPACK_PACKAGE_VENDOR "the Sluice developers")
set(CPACK_PACKAGE_CONTACT "the Sluice developers")  # as in LICENSE
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_DESCRIPTION
"Sluice couples solvers that run as separate executables over ZeroMQ, MPI or
shared memory; one YAML file, the scene, says who takes part and what flows.
This package has the command sluice, solvers for grains (dem), fluid (lbm) and
continua (mpm), scenes ready to run, and the library for participants of your own in C++, C
or Python. The solvers use AVX-512 or AVX2 where the processor has it.")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)  # libsluice: and so that ldconfig runs
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS
    "python3-numpy, python3-h5py, python3-matplotlib, graphviz, openmpi-bin")  # report; graph; transport: mpi
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "g++, cmake, pkg-config, libyaml-cpp-dev")  # for a participant of one's own
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
                                                WORLD_READ WORLD_EXECUTE)
if(SLUICE_NATIVE)  # what is built here is for this machine: cpack builds the portable one beside it
  configure_file(${CMAKE_SOURCE_DIR}/coupler/packaging/portable.cmake.in ${CMAKE_BINARY_DIR}/packaging/portable.cmake @ONLY)
  set(CPACK_PROJECT_CONFIG_FILE ${CMAKE_BINARY_DIR}/packaging/portable.cmake)
endif()
include(CPack)
