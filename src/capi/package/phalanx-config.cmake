# find_package(phalanx): phalanx::phalanx and phalanx::phalanx_files, and each as a static library (phalanx::phalanx_static).
get_filename_component(phalanx_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
foreach(library phalanx phalanx_files)
  if(NOT TARGET phalanx::${library})
    add_library(phalanx::${library} SHARED IMPORTED)
    set_target_properties(phalanx::${library} PROPERTIES
      IMPORTED_LOCATION "${phalanx_prefix}/lib/lib${library}.so.0"
      IMPORTED_SONAME "lib${library}.so.0"
      INTERFACE_INCLUDE_DIRECTORIES "${phalanx_prefix}/include")
    add_library(phalanx::${library}_static STATIC IMPORTED)
    set_target_properties(phalanx::${library}_static PROPERTIES
      IMPORTED_LOCATION "${phalanx_prefix}/lib/lib${library}.a"
      INTERFACE_LINK_LIBRARIES "m;pthread;dl"
      INTERFACE_INCLUDE_DIRECTORIES "${phalanx_prefix}/include")
  endif()
endforeach()
