# UMFPACK and CHOLMOD of SuiteSparse, which brings no package files of its own in version 5: targets UMFPACK::UMFPACK and
# CHOLMOD::CHOLMOD.
include(FindPackageHandleStandardArgs)
set(samara_solver_variables)
foreach(solver UMFPACK CHOLMOD)
  string(TOLOWER ${solver} file)
  find_path(${solver}_INCLUDE_DIR ${file}.h PATH_SUFFIXES suitesparse)
  find_library(${solver}_LIBRARY ${file})
  mark_as_advanced(${solver}_INCLUDE_DIR ${solver}_LIBRARY)
  list(APPEND samara_solver_variables ${solver}_LIBRARY ${solver}_INCLUDE_DIR)
endforeach()
find_package_handle_standard_args(SparseSolvers REQUIRED_VARS ${samara_solver_variables})
foreach(solver UMFPACK CHOLMOD)
  if(SparseSolvers_FOUND AND NOT TARGET ${solver}::${solver})
    add_library(${solver}::${solver} UNKNOWN IMPORTED)
    set_target_properties(${solver}::${solver} PROPERTIES
      IMPORTED_LOCATION "${${solver}_LIBRARY}" INTERFACE_INCLUDE_DIRECTORIES "${${solver}_INCLUDE_DIR}")
  endif()
endforeach()
