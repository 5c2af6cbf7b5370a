# find_package(phalanx): phalanx::phalanx, phalanx::phalanx_files, and the first as a static library, phalanx::phalanx_static.
get_filename_component(phalanx_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
foreach(library phalanx phalanx_files phalanx_static)
  if(TARGET phalanx::${library})
    continue()
  endif()
  if(library STREQUAL phalanx_static)
    add_library(phalanx::phalanx_static STATIC IMPORTED)
    set_target_properties(phalanx::phalanx_static PROPERTIES
      IMPORTED_LOCATION "${phalanx_prefix}/lib/libphalanx.a"
      INTERFACE_LINK_LIBRARIES "m;pthread;dl")
  else()
    add_library(phalanx::${library} SHARED IMPORTED)
    set_target_properties(phalanx::${library} PROPERTIES
      IMPORTED_LOCATION "${phalanx_prefix}/lib/lib${library}.so.0"
      IMPORTED_SONAME "lib${library}.so.0")
  endif()
  set_target_properties(phalanx::${library} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${phalanx_prefix}/include")
endforeach()
