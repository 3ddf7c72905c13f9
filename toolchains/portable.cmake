# With FACET_PORTABLE the program is linked statically, libc included: it needs nothing but the kernel, so that one file
# runs on every distribution. Include it before anything is looked for.
#
# What of libc does not work in such a program, or only with the same libc beside it, is not used: names of hosts
# (addresses are numbers), conversions of character sets, locales, loading of libraries. Names of groups are found in
# /etc/group, not in what else nsswitch.conf names.
option(FACET_PORTABLE "Link the program statically, libc included" OFF)
if(NOT FACET_PORTABLE)
  return()
endif()
set(CMAKE_FIND_LIBRARY_SUFFIXES .a)
string(APPEND CMAKE_EXE_LINKER_FLAGS " -static")
set(CMAKE_POSITION_INDEPENDENT_CODE OFF)

# Debian has fmt as headers and a shared library. Its targets, and that of yaml-cpp, name shared libraries: these are in
# their place.
find_path(Fmt_INCLUDE_DIR fmt/format-inl.h REQUIRED)
add_library(fmt::fmt INTERFACE IMPORTED GLOBAL)
target_include_directories(fmt::fmt SYSTEM INTERFACE "${Fmt_INCLUDE_DIR}")
target_compile_definitions(fmt::fmt INTERFACE FMT_HEADER_ONLY=1)
find_path(YamlCpp_INCLUDE_DIR yaml-cpp/yaml.h REQUIRED)
find_library(YamlCpp_LIBRARY yaml-cpp REQUIRED)
add_library(yaml-cpp UNKNOWN IMPORTED GLOBAL)
set_target_properties(yaml-cpp PROPERTIES
  IMPORTED_LOCATION "${YamlCpp_LIBRARY}" INTERFACE_INCLUDE_DIRECTORIES "${YamlCpp_INCLUDE_DIR}")

# What the archive of libtiff calls; a shared one names it itself. Call it once TIFF was found.
function(facet_complete_static_tiff)
  foreach(_name webp Lerc jbig zstd lzma jpeg deflate z)
    find_library(Tiff_${_name}_LIBRARY ${_name} REQUIRED)
    list(APPEND _libraries "${Tiff_${_name}_LIBRARY}")
  endforeach()
  set_property(TARGET TIFF::TIFF APPEND PROPERTY INTERFACE_LINK_LIBRARIES ${_libraries})
endfunction()
