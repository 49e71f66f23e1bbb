# Installs libraries, headers and what find_package(samara) needs.
include(CMakePackageConfigHelpers)
get_property(samara_rooms GLOBAL PROPERTY SAMARA_ROOMS)
get_property(samara_room_parts GLOBAL PROPERTY SAMARA_ROOM_PARTS)
set(samara_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/samara)

install(TARGETS ${samara_rooms} ${samara_room_parts} EXPORT samaraTargets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(EXPORT samaraTargets NAMESPACE samara:: DESTINATION ${samara_cmake_dir})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/samaraConfig.cmake.in
  ${CMAKE_CURRENT_BINARY_DIR}/samaraConfig.cmake INSTALL_DESTINATION ${samara_cmake_dir})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/samaraConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/samaraConfig.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/samaraConfigVersion.cmake DESTINATION ${samara_cmake_dir})
install(FILES ${CMAKE_CURRENT_LIST_DIR}/FindSparseSolvers.cmake DESTINATION ${samara_cmake_dir})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
