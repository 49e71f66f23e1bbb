# Packages for Debian, by CPack: ./dev package. The command, the libraries, and what programs are built with.
#
# Whoever makes packages for others sets SAMARA_MAINTAINER; none may be made for the instruction set of one machine.
set(SAMARA_MAINTAINER "The Samara authors <samara@lists.example.org>" CACHE STRING "Who stands in packages as their maintainer")

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME samara)
set(CPACK_PACKAGE_VENDOR "The Samara authors")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "parametric solutions of bodies in a fluid, as certified files")
set(CPACK_PACKAGE_CONTACT "${SAMARA_MAINTAINER}")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/compress_manuals.cmake)
set(CPACK_COMPONENTS_ALL command library dev)
set(CPACK_PROJECT_CONFIG_FILE ${CMAKE_CURRENT_LIST_DIR}/package_checks.cmake)
set(CPACK_SAMARA_MACHINE_FLAGS "${SAMARA_MACHINE_FLAGS}")
set(CPACK_SAMARA_SHARED "${BUILD_SHARED_LIBS}")

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE "")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(samara_private)  # where the libraries lie of which the packages bring their own
foreach(room ${samara_all_rooms})
  list(APPEND samara_private ${PROJECT_BINARY_DIR}/${room})
endforeach()
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${samara_private})
set(samara_runtime libsamara${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})

set(CPACK_DEBIAN_COMMAND_PACKAGE_NAME samara)
set(CPACK_DEBIAN_COMMAND_PACKAGE_SECTION science)
set(CPACK_DEBIAN_COMMAND_PACKAGE_DEPENDS "${samara_runtime} (= ${PROJECT_VERSION})")
set(CPACK_COMPONENT_COMMAND_DESCRIPTION
  "Samara computes the motion of a body in a fluid for all parameters and
starting values of a box at once, as a separated representation (proper
generalized decomposition, tensor trains). It certifies the result against
an independent integrator, answers from it in microseconds with exact
derivatives, and fits force coefficients to filmed motion.
.
This package has the command, its pages and its examples.")

set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME ${samara_runtime})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
# Which package to ask for where a program links one of them. CPack would write this too, with scripts beside it that a
# trigger makes superfluous.
set(samara_shlibs)
foreach(target ${samara_rooms} ${samara_room_parts})
  get_target_property(kind ${target} TYPE)
  if(kind STREQUAL SHARED_LIBRARY)
    string(APPEND samara_shlibs "lib${target} ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} ${samara_runtime} (= ${PROJECT_VERSION})\n")
  endif()
endforeach()
file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/debian/shlibs CONTENT "${samara_shlibs}")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA
  ${CMAKE_CURRENT_LIST_DIR}/debian/triggers ${CMAKE_CURRENT_BINARY_DIR}/debian/shlibs)
set(CPACK_COMPONENT_LIBRARY_DESCRIPTION
  "Samara computes the motion of a body in a fluid for all parameters and
starting values of a box at once, certifies the result, answers from it in
microseconds, and fits force coefficients to filmed motion.
.
This package has the libraries that programs need to run.")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME libsamara-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "${samara_runtime} (= ${PROJECT_VERSION}), libeigen3-dev (>= 3.4)")
set(CPACK_COMPONENT_DEV_DESCRIPTION
  "Samara computes the motion of a body in a fluid for all parameters and
starting values of a box at once, certifies the result, answers from it in
microseconds, and fits force coefficients to filmed motion.
.
This package has the headers for C++ and C, and files for CMake and
pkg-config.")

# What every package of Debian has: who may copy it, and what has changed.
find_program(samara_gzip gzip)
# Their date is that of the version in CHANGELOG.md.
file(STRINGS ${PROJECT_SOURCE_DIR}/CHANGELOG.md samara_heading REGEX "^## ${PROJECT_VERSION}, ")
string(REGEX MATCH "[0-9]+-[0-9]+-[0-9]+" samara_day "${samara_heading}")
execute_process(COMMAND ${CMAKE_COMMAND} -E env LC_ALL=C date -u -R -d "${samara_day} 12:00" OUTPUT_VARIABLE samara_date
  OUTPUT_STRIP_TRAILING_WHITESPACE)
configure_file(${CMAKE_CURRENT_LIST_DIR}/debian/changelog.in ${CMAKE_CURRENT_BINARY_DIR}/debian/changelog @ONLY)
if(samara_gzip)
  execute_process(COMMAND ${samara_gzip} -9 -n -k -f ${CMAKE_CURRENT_BINARY_DIR}/debian/changelog)
endif()
foreach(component command library dev)
  string(TOUPPER ${component} upper)
  set(folder share/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  install(FILES ${CMAKE_CURRENT_LIST_DIR}/debian/copyright ${CMAKE_CURRENT_BINARY_DIR}/debian/changelog.gz
    DESTINATION ${folder} COMPONENT ${component} EXCLUDE_FROM_ALL)
  if(EXISTS ${CMAKE_CURRENT_LIST_DIR}/debian/${component}.lintian-overrides)
    install(FILES ${CMAKE_CURRENT_LIST_DIR}/debian/${component}.lintian-overrides COMPONENT ${component} EXCLUDE_FROM_ALL
      DESTINATION share/lintian/overrides RENAME ${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  endif()
endforeach()
include(CPack)
