# Installs libraries, headers and what find_package(samara) and pkg-config need. Components: "command", "library" (what
# a program needs to run), "dev" (what it needs to be built).
include(CMakePackageConfigHelpers)
get_property(samara_rooms GLOBAL PROPERTY SAMARA_ROOMS)
get_property(samara_room_parts GLOBAL PROPERTY SAMARA_ROOM_PARTS)
set(samara_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/samara)

install(TARGETS ${samara_rooms} ${samara_room_parts} EXPORT samaraTargets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT dev
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT library)
install(EXPORT samaraTargets NAMESPACE samara:: DESTINATION ${samara_cmake_dir} COMPONENT dev)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/samaraConfig.cmake.in
  ${CMAKE_CURRENT_BINARY_DIR}/samaraConfig.cmake INSTALL_DESTINATION ${samara_cmake_dir})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/samaraConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/samaraConfig.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/samaraConfigVersion.cmake DESTINATION ${samara_cmake_dir} COMPONENT dev)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/FindSparseSolvers.cmake DESTINATION ${samara_cmake_dir} COMPONENT dev)

# pkg-config is for programs in C: a file for each library that they link. Where it stands is found from the file
# itself, so that the prefix may be moved.
function(samara_pc samara_pc_name samara_pc_library samara_pc_description)
  file(RELATIVE_PATH samara_pc_to_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
  set(file ${CMAKE_CURRENT_BINARY_DIR}/${samara_pc_name}.pc)
  configure_file(${CMAKE_CURRENT_FUNCTION_LIST_DIR}/samara.pc.in ${file} @ONLY)
  install(FILES ${file} DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)
endfunction()
if(samara_has_codebooks AND BUILD_SHARED_LIBS)
  samara_pc(samara samara_c "Codebooks of bodies moving in a fluid, asked from C")
endif()
if(samara_has_motion AND BUILD_SHARED_LIBS)
  samara_pc(samara-motion samara_motion_c "Many falling bodies at run time, from C")
endif()

# Pages and examples come with the command. Packages have the licence in a file of their own kind.
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT licence)
install(FILES ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CITATION.cff DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT command)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT command
  PATTERN "site" EXCLUDE PATTERN "*.py" EXCLUDE)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT command
  PATTERN "__pycache__" EXCLUDE PATTERN "*.h5" EXCLUDE)
