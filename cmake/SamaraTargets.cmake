# samara_room(<name> [SUB_ROOMS ...] HEADERS ... [EXCEPT ...] [PUBLIC ...] [PRIVATE ...])
#
# One library per folder: target samara_<name>, exported as samara::<name>, of all sources in its sub-rooms (or in the
# folder itself, where there are none) but those in EXCEPT. HEADERS are installed under include/samara/<name>, the
# others are internal; in the build tree the same include paths work through links.
function(samara_room name)
  cmake_parse_arguments(ROOM "" "" "SUB_ROOMS;HEADERS;EXCEPT;PUBLIC;PRIVATE" ${ARGN})
  set(target samara_${name})
  if(NOT ROOM_SUB_ROOMS)
    set(ROOM_SUB_ROOMS .)
  endif()
  add_library(${target})
  foreach(sub_room ${ROOM_SUB_ROOMS})
    file(GLOB sources RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} CONFIGURE_DEPENDS
      ${CMAKE_CURRENT_SOURCE_DIR}/${sub_room}/*.cpp)
    if(ROOM_EXCEPT)
      list(REMOVE_ITEM sources ${ROOM_EXCEPT})
    endif()
    target_sources(${target} PRIVATE ${sources})
    list(APPEND room_sources ${sources})
  endforeach()
  samara_compile_together(${target} ${room_sources})
  samara_library(${target} PUBLIC ${ROOM_PUBLIC} PRIVATE ${ROOM_PRIVATE})
  add_library(samara::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${samara_BINARY_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  file(MAKE_DIRECTORY ${samara_BINARY_DIR}/include/samara)
  file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR} ${samara_BINARY_DIR}/include/samara/${name} SYMBOLIC)
  set_property(GLOBAL APPEND PROPERTY SAMARA_ROOMS ${target})
  if(SAMARA_INSTALL)
    foreach(header ${ROOM_HEADERS})  # keeps the folders below the room
      cmake_path(GET header PARENT_PATH folder)
      install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/samara/${name}/${folder} COMPONENT dev)
    endforeach()
  endif()
endfunction()

# samara_compile_together(<target> [ACROSS_FOLDERS] [FILES <number>] <source> ...)
#
# With SAMARA_UNITY_BUILD these sources of the target share compilations, about that many files each, or eight: most of
# the time of a small file is that of its headers and of what they instantiate. Twice as many take a tenth less time, in
# the command a third. Those with flags of their own stay alone. Names in anonymous namespaces are unique among files
# that may meet (tests/structure): those of a folder, those of all folders of few files, which share compilations, too,
# and with ACROSS_FOLDERS all of them.
function(samara_compile_together target)
  if(SAMARA_UNITY_BUILD)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
    # A type of an anonymous namespace in a class of its own source looks to GCC as if a header had it.
    target_compile_options(${target} PRIVATE "$<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>")
    cmake_language(EVAL CODE "cmake_language(DEFER CALL samara_group_sources ${ARGN})")  # when all flags are known
  endif()
endfunction()

function(samara_group_sources)
  cmake_parse_arguments(TOGETHER "ACROSS_FOLDERS" "FILES" "" ${ARGN})
  if(NOT TOGETHER_FILES)
    set(TOGETHER_FILES 8)
  endif()
  set(few 4)
  set(folders)
  foreach(source ${TOGETHER_UNPARSED_ARGUMENTS})
    get_source_file_property(flags ${source} COMPILE_OPTIONS)
    get_source_file_property(is_alone ${source} SKIP_UNITY_BUILD_INCLUSION)
    if(flags OR is_alone)
      continue()
    endif()
    set(folder all)
    if(NOT TOGETHER_ACROSS_FOLDERS)
      cmake_path(GET source PARENT_PATH folder)
      string(MAKE_C_IDENTIFIER "in_${folder}" folder)
    endif()
    list(APPEND folders ${folder})
    list(APPEND sources_${folder} ${source})
  endforeach()
  list(REMOVE_DUPLICATES folders)
  foreach(folder ${folders})
    list(LENGTH sources_${folder} count)
    if(count LESS_EQUAL few)
      list(APPEND sources_few ${sources_${folder}})
      list(REMOVE_ITEM folders ${folder})
    endif()
  endforeach()
  foreach(folder ${folders} few)
    list(LENGTH sources_${folder} count)
    # Of equal size, and a quarter of a batch more makes no other.
    math(EXPR batches "(${count} + ${TOGETHER_FILES} * 3 / 4 - 1) / ${TOGETHER_FILES}")
    if(batches EQUAL 0)
      set(batches 1)
    endif()
    set(index 0)
    foreach(source ${sources_${folder}})
      math(EXPR batch "${index} * ${batches} / ${count}")
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP "${folder}_${batch}")
      math(EXPR index "${index} + 1")
    endforeach()
  endforeach()
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

# Eigen as our own sources read it, precompiled: the dear parts are compiled once, in the room base.
set(SAMARA_EIGEN_DECOMPOSITIONS ${PROJECT_SOURCE_DIR}/base/eigen_decompositions.h)

# What all our libraries have in common.
function(samara_library target)
  target_link_libraries(${target} ${ARGN})
  set_target_properties(${target} PROPERTIES
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
    POSITION_INDEPENDENT_CODE ON)
  samara_compile_options(${target})
  if("fmt::fmt" IN_LIST ARGN AND NOT target STREQUAL "samara_base")  # which knows no Eigen
    samara_precompile(${target} samara_library_headers ${SAMARA_EIGEN_DECOMPOSITIONS} <fmt/format.h> <algorithm> <cmath>
      <string> <vector>)
  endif()
endfunction()

# samara_precompile(<target> <holder> <header> ...)
#
# Headers that nearly every source reads, compiled once for all targets that name the same holder, or for the target
# alone, which then holds them itself: an eighth to a quarter of the time of a file. Their sources are optimised alike
# (GCC takes the level from the precompiled header, whatever the command says), see Eigen's alignment and use fmt. From
# there GCC 12 no longer knows the standard library's headers as such, and warns of them. The preset "dev" does
# without, so that no source relies on what it does not include, and every warning is seen.
function(samara_precompile target holder)
  if(CMAKE_DISABLE_PRECOMPILE_HEADERS)
    return()
  endif()
  if(NOT TARGET ${holder})
    file(CONFIGURE OUTPUT ${samara_BINARY_DIR}/${holder}.cpp CONTENT "")
    add_library(${holder} OBJECT ${samara_BINARY_DIR}/${holder}.cpp)
    target_link_libraries(${holder} PRIVATE Eigen3::Eigen)
    if("<fmt/format.h>" IN_LIST ARGN)
      target_link_libraries(${holder} PRIVATE fmt::fmt)
    endif()
    target_compile_definitions(${holder} PRIVATE $<TARGET_PROPERTY:samara_eigen,INTERFACE_COMPILE_DEFINITIONS>)
    target_compile_options(${holder} PRIVATE $<TARGET_PROPERTY:${target},COMPILE_OPTIONS>)
    get_target_property(is_independent ${target} POSITION_INDEPENDENT_CODE)
    set_target_properties(${holder} PROPERTIES CXX_STANDARD 20 POSITION_INDEPENDENT_CODE "${is_independent}")
    target_precompile_headers(${holder} PRIVATE ${ARGN})
  endif()
  if(holder STREQUAL target)
    target_precompile_headers(${target} PRIVATE ${ARGN})
  else()
    target_precompile_headers(${target} REUSE_FROM ${holder})
  endif()
  target_compile_options(${target} PRIVATE
    "$<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread;-Wno-restrict>")
endfunction()

# Warnings and sanitizers for our own code (never passed on to users of the libraries).
function(samara_compile_options target)
  set_target_properties(${target} PROPERTIES SAMARA_OWN_TARGET ON)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wconversion -Wshadow
    $<$<BOOL:${SAMARA_WARNINGS_AS_ERRORS}>:-Werror>)
  if(SAMARA_UNITY_BUILD)
    # Garbage that GCC collects before it holds 1 GB costs a tenth of the time of a build.
    target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=1048576>)
  endif()
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
