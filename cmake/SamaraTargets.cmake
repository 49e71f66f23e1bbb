# samara_room(<name> HEADERS ... [INTERNAL_HEADERS ...] [SOURCES ...] [PUBLIC ...] [PRIVATE ...])
#
# One library per folder: target samara_<name>, exported as samara::<name>. HEADERS are installed under
# include/samara/<name>; in the build tree the same include paths work through links.
function(samara_room name)
  cmake_parse_arguments(ROOM "" "" "HEADERS;INTERNAL_HEADERS;SOURCES;PUBLIC;PRIVATE" ${ARGN})
  set(target samara_${name})
  if(ROOM_SOURCES)
    add_library(${target} ${ROOM_SOURCES} ${ROOM_HEADERS} ${ROOM_INTERNAL_HEADERS})
    set(scope PUBLIC)
    samara_library(${target} PUBLIC ${ROOM_PUBLIC} PRIVATE ${ROOM_PRIVATE})
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
    target_link_libraries(${target} INTERFACE ${ROOM_PUBLIC})
  endif()
  add_library(samara::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(${target} ${scope} cxx_std_20)
  target_include_directories(${target} ${scope}
    $<BUILD_INTERFACE:${samara_BINARY_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  file(MAKE_DIRECTORY ${samara_BINARY_DIR}/include/samara)
  file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR} ${samara_BINARY_DIR}/include/samara/${name} SYMBOLIC)
  set_property(GLOBAL APPEND PROPERTY SAMARA_ROOMS ${target})
  if(SAMARA_INSTALL)
    foreach(header ${ROOM_HEADERS})  # keeps the folders below the room
      cmake_path(GET header PARENT_PATH folder)
      install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/samara/${name}/${folder})
    endforeach()
  endif()
endfunction()

# samara_room_part(<name> SOURCES ... [PUBLIC ...] [PRIVATE ...])
#
# A library of its own for sources of this room that bring along what most users should not load: target
# samara_<name>, exported as samara::<name>, not part of samara::samara.
function(samara_room_part name)
  cmake_parse_arguments(PART "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  set(target samara_${name})
  add_library(${target} ${PART_SOURCES})
  samara_library(${target} PUBLIC ${PART_PUBLIC} PRIVATE ${PART_PRIVATE})
  add_library(samara::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_property(GLOBAL APPEND PROPERTY SAMARA_ROOM_PARTS ${target})
endfunction()

# To be included in front of sources with machine flags; users get it with samara::eigen.
set(SAMARA_EIGEN_ALIGNMENT samara/base/eigen_alignment.h)

# What all our libraries have in common.
function(samara_library target)
  target_link_libraries(${target} ${ARGN})
  samara_compile_options(${target})
  if("fmt::fmt" IN_LIST ARGN)
    samara_precompile(${target} <Eigen/Core> <fmt/format.h> <algorithm> <cmath> <string> <vector>)
  endif()
  set_target_properties(${target} PROPERTIES
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
    POSITION_INDEPENDENT_CODE ON)
endfunction()

# Headers that nearly every source reads, compiled once per target: an eighth to a quarter of the time of a file. From
# there GCC 12 no longer knows the standard library's headers as such, and warns of them. The presets of the long
# checks do without, so that no source relies on what it does not include, and every warning is seen.
function(samara_precompile target)
  if(CMAKE_DISABLE_PRECOMPILE_HEADERS)
    return()
  endif()
  target_precompile_headers(${target} PRIVATE ${ARGN})
  target_compile_options(${target} PRIVATE
    "$<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread;-Wno-restrict>")
endfunction()

# Warnings and sanitizers for our own code (never passed on to users of the libraries).
function(samara_compile_options target)
  set_target_properties(${target} PROPERTIES SAMARA_OWN_TARGET ON)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wconversion -Wshadow
    $<$<BOOL:${SAMARA_WARNINGS_AS_ERRORS}>:-Werror>)
  if(SAMARA_SANITIZE)
    target_compile_options(${target} PRIVATE -fsanitize=${SAMARA_SANITIZE} -fno-omit-frame-pointer
      -fno-sanitize-recover=all)
    # GCC 12 sees uninitialised memory in Eigen's expressions once the sanitizers have rewritten them.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-error=maybe-uninitialized>)
    target_link_options(${target} PRIVATE -fsanitize=${SAMARA_SANITIZE})
  endif()
endfunction()

# samara::samara stands for all rooms.
function(samara_umbrella)
  get_property(rooms GLOBAL PROPERTY SAMARA_ROOMS)
  add_library(samara_samara INTERFACE)
  add_library(samara::samara ALIAS samara_samara)
  set_target_properties(samara_samara PROPERTIES EXPORT_NAME samara)
  target_link_libraries(samara_samara INTERFACE ${rooms})
  set_property(GLOBAL APPEND PROPERTY SAMARA_ROOMS samara_samara)
endfunction()
