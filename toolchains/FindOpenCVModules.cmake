# Single OpenCV 4 modules as imported targets OpenCVModules::<component>.
#
# Debian ships OpenCV's CMake package only in libopencv-dev, which pulls in several hundred packages; the -dev
# packages of single modules have headers and libraries but no CMake package. This finds those.
find_path(OpenCVModules_INCLUDE_DIR opencv2/core/version.hpp PATH_SUFFIXES opencv4)

if(OpenCVModules_INCLUDE_DIR)
  set(_version_file "${OpenCVModules_INCLUDE_DIR}/opencv2/core/version.hpp")
  foreach(_part MAJOR MINOR REVISION)
    file(STRINGS "${_version_file}" _line REGEX "#define CV_VERSION_${_part} +[0-9]+")
    string(REGEX MATCH "[0-9]+" _number "${_line}")
    list(APPEND _numbers "${_number}")
  endforeach()
  list(JOIN _numbers "." OpenCVModules_VERSION)
  unset(_numbers)
endif()

foreach(_module IN LISTS OpenCVModules_FIND_COMPONENTS)
  find_library(OpenCVModules_${_module}_LIBRARY opencv_${_module})
  find_path(OpenCVModules_${_module}_HEADER opencv2/${_module}.hpp PATH_SUFFIXES opencv4)
  if(OpenCVModules_${_module}_LIBRARY AND OpenCVModules_${_module}_HEADER)
    set(OpenCVModules_${_module}_FOUND TRUE)
  endif()
endforeach()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCVModules
  REQUIRED_VARS OpenCVModules_INCLUDE_DIR
  VERSION_VAR OpenCVModules_VERSION
  HANDLE_COMPONENTS)

if(OpenCVModules_FOUND)
  foreach(_module IN LISTS OpenCVModules_FIND_COMPONENTS)
    if(NOT TARGET OpenCVModules::${_module})
      add_library(OpenCVModules::${_module} UNKNOWN IMPORTED)
      set_target_properties(OpenCVModules::${_module} PROPERTIES
        IMPORTED_LOCATION "${OpenCVModules_${_module}_LIBRARY}"
        INTERFACE_INCLUDE_DIRECTORIES "${OpenCVModules_INCLUDE_DIR}")
    endif()
  endforeach()
endif()
