# Read by CPack before it makes a package.
if(CPACK_SAMARA_MACHINE_FLAGS)
  message(FATAL_ERROR "this build is for one machine (SAMARA_MACHINE_FLAGS is \"${CPACK_SAMARA_MACHINE_FLAGS}\"), which a "
    "package must not be; make packages by ./dev package")
endif()
if(NOT CPACK_SAMARA_SHARED)
  message(FATAL_ERROR "packages are made of shared libraries, and BUILD_SHARED_LIBS is off; make them by ./dev package")
endif()
