# Targets: cullet::cullet, the shared library, and but for MSVC cullet::static.
get_filename_component(_cullet_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
if(NOT TARGET cullet::cullet)
  add_library(cullet::cullet SHARED IMPORTED)
  set(_cullet_shared "${_cullet_prefix}/lib/libcullet.so.0")
  if(WIN32)
    set(_cullet_shared "${_cullet_prefix}/bin/cullet.dll")
  elseif(APPLE)
    set(_cullet_shared "${_cullet_prefix}/lib/libcullet.dylib")
  endif()
  set_target_properties(cullet::cullet PROPERTIES
    IMPORTED_LOCATION "${_cullet_shared}"
    INTERFACE_INCLUDE_DIRECTORIES "${_cullet_prefix}/include")
  if(MSVC)
    set_target_properties(cullet::cullet PROPERTIES IMPORTED_IMPLIB "${_cullet_prefix}/lib/cullet.lib")
  elseif(WIN32)
    set_target_properties(cullet::cullet PROPERTIES IMPORTED_IMPLIB "${_cullet_prefix}/lib/libcullet.dll.a")
  elseif(NOT APPLE)
    set_target_properties(cullet::cullet PROPERTIES IMPORTED_SONAME libcullet.so.0)
  endif()
endif()
# The static library has the runtime of MinGW in it.
if(NOT MSVC AND NOT TARGET cullet::static)
  add_library(cullet::static STATIC IMPORTED)
  set_target_properties(cullet::static PROPERTIES
    IMPORTED_LOCATION "${_cullet_prefix}/lib/libcullet.a"
    INTERFACE_INCLUDE_DIRECTORIES "${_cullet_prefix}/include")
  if(UNIX AND NOT APPLE)
    # What nothing calls is left out of the program.
    set_target_properties(cullet::static PROPERTIES
      INTERFACE_LINK_LIBRARIES "gcc_s;util;rt;pthread;m;dl"
      INTERFACE_LINK_OPTIONS "-Wl,--gc-sections")
  elseif(WIN32)
    set_target_properties(cullet::static PROPERTIES INTERFACE_LINK_LIBRARIES "kernel32;ntdll;userenv;ws2_32;dbghelp")
  endif()
endif()
unset(_cullet_shared)
unset(_cullet_prefix)
