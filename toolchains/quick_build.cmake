# What makes a build from nothing quick. Both are off where ccache is at work, whose hits are cheaper still: there every
# source is compiled by itself, and one that forgets an include fails.
if(CCACHE_PROGRAM OR FACET_FOR_PACKAGE)
  set(_default OFF)
else()
  set(_default ON)
endif()

# Up to eight sources of a target compiled as one: templates of Eigen, fmt and json that they share are instantiated
# once, which takes almost half off. So names of a target's anonymous namespaces must differ. Sources with flags of
# their own stay alone. The results are the same to the last bit with and without: none depends on what is inlined, as
# long as no library brings compiled functions of Eigen along (app/lab/calibrate/keep_eigen_apart.cmake).
option(FACET_UNITY_BUILD "Compile the sources of a target together" ${_default})
set(CMAKE_UNITY_BUILD ${FACET_UNITY_BUILD})

# Precompiled headers: what most sources include of Eigen and the standard library is parsed once, which takes a quarter
# off. Only headers that most sources use: with CLI11 and nlohmann's json among them, sources that use neither took
# twice as long.
option(FACET_PRECOMPILED_HEADERS "Precompile the headers most sources include" ${_default})

set(_facet_common_headers
  <algorithm> <array> <cmath> <cstdint> <optional> <span> <string> <string_view> <utility> <vector>
  <Eigen/Cholesky> <Eigen/Core> <Eigen/Geometry> <Eigen/LU>)

# One set for each combination of flags, since the compiler accepts precompiled headers made with its own flags only.
function(_facet_add_precompiled_headers name)
  cmake_parse_arguments(ARG "" "" "LIBS;HEADERS" ${ARGN})
  file(CONFIGURE OUTPUT "${CMAKE_BINARY_DIR}/${name}.cpp" CONTENT "// Nothing but the precompiled headers.\n")
  add_library(${name} OBJECT "${CMAKE_BINARY_DIR}/${name}.cpp")
  target_link_libraries(${name} PRIVATE ${ARG_LIBS} Eigen3::Eigen)
  target_precompile_headers(${name} PRIVATE ${ARG_HEADERS})
endfunction()

function(_facet_targets_below folder result)
  get_property(targets DIRECTORY "${folder}" PROPERTY BUILDSYSTEM_TARGETS)
  get_property(subfolders DIRECTORY "${folder}" PROPERTY SUBDIRECTORIES)
  foreach(subfolder IN LISTS subfolders)
    _facet_targets_below("${subfolder}" below)
    list(APPEND targets ${below})
  endforeach()
  set(${result} "${targets}" PARENT_SCOPE)
endfunction()

# Call it once, last: gives every target made so far the set that fits its flags. Targets, and sources, with flags of
# their own go without.
function(facet_use_precompiled_headers)
  if(NOT FACET_PRECOMPILED_HEADERS)
    return()
  endif()
  _facet_targets_below("${CMAKE_SOURCE_DIR}" targets)
  _facet_add_precompiled_headers(facet_headers LIBS facet_flags HEADERS ${_facet_common_headers})
  _facet_add_precompiled_headers(facet_headers_pure LIBS facet_flags_pure HEADERS ${_facet_common_headers})
  if(BUILD_TESTING)
    _facet_add_precompiled_headers(facet_headers_tests LIBS facet_flags facet_catch_main
      HEADERS ${_facet_common_headers} <catch2/catch.hpp>)
  endif()
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    get_target_property(own_options ${target} COMPILE_OPTIONS)
    get_target_property(libraries ${target} LINK_LIBRARIES)
    if(NOT type MATCHES "^(STATIC_LIBRARY|EXECUTABLE)$" OR own_options)
      continue()
    endif()
    if("facet_flags_pure" IN_LIST libraries)
      target_precompile_headers(${target} REUSE_FROM facet_headers_pure)
    elseif("facet_catch_main" IN_LIST libraries)
      target_precompile_headers(${target} REUSE_FROM facet_headers_tests)
    else()
      target_precompile_headers(${target} REUSE_FROM facet_headers)
    endif()
  endforeach()
endfunction()
