# Installs estimator, mesh and plane finder as a library that other programs find with find_package(facet):
#   cmake --install BUILD_FOLDER --component development --prefix FOLDER
# Headers keep their paths, below include/facet. docs/example is a program that uses it. The Debian package leaves it
# out.
include(CMakePackageConfigHelpers)

# All that facet::mapping and facet::world_reader consist of, of which other programs may use each by itself; CMake
# refuses a list that lacks one of them.
foreach(_part flags flags_pure platform_base geometry values imu frontend factors solver window estimator_api estimator
    mesh depth places planes volume mapping world_reader)
  set_target_properties(facet_${_part} PROPERTIES EXPORT_NAME ${_part})
  install(TARGETS facet_${_part} EXPORT facet_library ARCHIVE DESTINATION lib COMPONENT development)
endforeach()
install(DIRECTORY platform/base DESTINATION include/facet/platform COMPONENT development FILES_MATCHING PATTERN "*.h")
install(DIRECTORY estimator mesh DESTINATION include/facet COMPONENT development FILES_MATCHING PATTERN "*.h"
  PATTERN "estimator/flight" EXCLUDE)
install(FILES drivers/world_stream/world_message.h drivers/world_stream/world_reader.h
  drivers/world_stream/world_state.h DESTINATION include/facet/drivers/world_stream COMPONENT development)

# A front-end on OpenCV makes the library need its modules.
set(_find_opencv "")
if(FACET_OPENCV_FRONTEND)
  install(FILES toolchains/FindOpenCVModules.cmake DESTINATION lib/cmake/facet COMPONENT development)
  set(_find_opencv "list(APPEND CMAKE_MODULE_PATH \"\${CMAKE_CURRENT_LIST_DIR}\")
find_dependency(OpenCVModules 4.5 COMPONENTS core imgproc features2d video)")
endif()

# The very versions the library was compiled with: their classes are in its interface, their functions on both sides.
set(_config "${CMAKE_BINARY_DIR}/install_library")
file(CONFIGURE OUTPUT "${_config}/facetConfig.cmake" @ONLY CONTENT [[
include(CMakeFindDependencyMacro)
find_dependency(Eigen3 @Eigen3_VERSION@ EXACT NO_MODULE)
find_dependency(Boost @Boost_VERSION_STRING@ EXACT)
@_find_opencv@
include("${CMAKE_CURRENT_LIST_DIR}/facetTargets.cmake")
]])
write_basic_package_version_file("${_config}/facetConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(DIRECTORY "${_config}/" DESTINATION lib/cmake/facet COMPONENT development)
install(EXPORT facet_library NAMESPACE facet:: FILE facetTargets.cmake
  DESTINATION lib/cmake/facet COMPONENT development)
